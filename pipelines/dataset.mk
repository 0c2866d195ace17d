# SPDX-License-Identifier: Apache-2.0
# Bodies, poses, splits and FEM samples.

# Motion folders to import: CMU's where the data folder has them beside others, otherwise all of motion/.
MOTION ?= $(or $(wildcard $(DATA)/motion/cmu_*),$(DATA)/motion)

CHECK_DATA = @test -n "$(DATA)" || { echo "Pass DATA=<folder> with makehuman/ and motion/ in it (docs/data.md says where" \
    "they come from): a body and motions built into the project do not exist yet." >&2; exit 2; }; \
    for d in makehuman motion; do test -d "$(DATA)/$$d" || { echo "DATA=$(DATA) has no folder $$d (docs/data.md)." >&2; exit 2; }; done
STAGE = @pipelines/stage.sh $(OUT)
RUN = --config $(CONFIG) --force

.PHONY: templates bodies poses dataset

templates: build ## the layered template, out/<preset>/template.h5
	@$(MAKE) --no-print-directory $(OUT)/template.h5
bodies: build ## sampled people with layers, out/<preset>/bodies.h5
	@$(MAKE) --no-print-directory $(OUT)/bodies.h5
poses: build ## motion capture on our skeleton and its farthest-point subset, out/<preset>/poses.h5
	@$(MAKE) --no-print-directory $(OUT)/poses.h5
dataset: build ## FEM samples, out/<preset>/fem.h5
	@$(MAKE) --no-print-directory $(OUT)/fem.h5

$(OUT)/template.h5: $(CONFIG)
	$(CHECK_DATA)
	$(STAGE) template $(BIN)/make-template $(RUN) --makehuman "$(DATA)/makehuman" --output $@

$(OUT)/skins.h5: $(OUT)/template.h5 $(CONFIG)
	$(CHECK_DATA)
	$(STAGE) sample-bodies $(BIN)/sample-bodies $(RUN) --template $< --makehuman "$(DATA)/makehuman" --output $@

$(OUT)/bodies.h5: $(OUT)/template.h5 $(OUT)/skins.h5 $(CONFIG)
	$(STAGE) build-layers $(BIN)/build-layers $(RUN) --template $(OUT)/template.h5 --skins $(OUT)/skins.h5 --output $@

$(OUT)/motion.h5: $(OUT)/template.h5 $(CONFIG)
	$(CHECK_DATA)
	$(STAGE) import-motion $(BIN)/import-motion $(RUN) --template $< --joint-maps configs/joint-maps \
	    $(addprefix --motion ,$(MOTION)) --output $@

$(OUT)/poses.h5: $(OUT)/motion.h5 $(CONFIG)
	$(STAGE) sample-poses $(BIN)/sample-poses $(RUN) --poses $< --output $@

$(OUT)/splits.h5: $(OUT)/template.h5 $(OUT)/bodies.h5 $(OUT)/poses.h5 $(CONFIG)
	$(STAGE) make-splits $(BIN)/make-splits $(RUN) --template $(OUT)/template.h5 --bodies $(OUT)/bodies.h5 \
	    --poses $(OUT)/poses.h5 --output $@

BODY_FILES = --template $(OUT)/template.h5 --bodies $(OUT)/bodies.h5 --poses $(OUT)/poses.h5
BODY_DEPS = $(OUT)/template.h5 $(OUT)/bodies.h5 $(OUT)/poses.h5

$(OUT)/fem.h5: $(BODY_DEPS) $(OUT)/splits.h5 $(CONFIG)
	$(STAGE) simulate-fem $(BIN)/simulate-fem --config $(CONFIG) --force $(BODY_FILES) --splits $(OUT)/splits.h5 --output $@
