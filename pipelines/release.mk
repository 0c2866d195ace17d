# SPDX-License-Identifier: Apache-2.0
# A trained network as something to pass on (docs/release.md).

RELEASE = $(OUT)/release

.PHONY: release
release: build ## the trained network to pass on, out/<preset>/release/: safetensors, ONNX, runtime model, cards, checksums
	@$(MAKE) --no-print-directory $(RELEASE)/SHA256SUMS
	@echo "release: $(RELEASE)/ ($$(du -sh $(RELEASE) | cut -f 1)); read $(RELEASE)/README.md"

# Tables as they are, where there are any; none are made. A network that nobody has evaluated can be passed on: its card says so.
RELEASE_TABLES = $(wildcard $(REPORT)/tables.json)
NEWER_TABLES = $(shell test $(REPORT)/tables.json -nt $(RELEASE)/SHA256SUMS && echo newer-tables)
.PHONY: newer-tables
newer-tables:
RELEASE_DATA = $(foreach name,template bodies poses splits fem,$(OUT)/$(name).h5)

$(RELEASE)/SHA256SUMS: $(OUT)/model.h5 $(RELEASE_DATA) $(NEWER_TABLES)
	@rm -rf $(RELEASE) && mkdir -p $(RELEASE)
	$(STAGE) export-release $(BIN)/export-release --model $(OUT)/model.h5 --name "NDG, $(PRESET)" $(addprefix --tables ,$(RELEASE_TABLES)) \
	    $(addprefix --data ,$(RELEASE_DATA)) --safetensors $(RELEASE)/model.safetensors --config-json $(RELEASE)/config.json \
	    --onnx $(RELEASE)/model.onnx --model-card $(RELEASE)/README.md --dataset-card $(RELEASE)/dataset-card.md
	$(STAGE) export-runtime $(BIN)/export-runtime --model $(OUT)/model.h5 --output $(RELEASE)/model.ndg
	@cp LICENSE $(OUT)/template.h5 $(OUT)/bodies.h5 $(RELEASE_TABLES) $(RELEASE)/
	@cd $(RELEASE) && sha256sum $$(ls | grep -v SHA256SUMS) > SHA256SUMS.tmp && mv SHA256SUMS.tmp SHA256SUMS
