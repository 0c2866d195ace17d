# SPDX-License-Identifier: Apache-2.0
# From scans to bodies: people are drawn, scanned by a simulated scanner, registered, and get their layers; what the fits
# are worth is measured against the truth. The data set (dataset.mk) does not pass through here: it takes the people as
# they were drawn.

# How many; empty: as many as the preset says.
BODIES ?=

FITTED = $(OUT)/fitted
FIT_STAGE = @pipelines/stage.sh $(FITTED)
BODIES_CHOICE = $(FITTED)/choice-bodies-$(or $(BODIES),preset)

.PHONY: bodies
bodies: tools ## people from simulated scans: registration and layers, measured, out/<preset>/fitted/; BODIES=<n>
	@$(MAKE) --no-print-directory $(FITTED)/report.txt $(FITTED)/worst.png
	@cat $(FITTED)/report.txt
	@echo "worst body: $(FITTED)/worst.png"

$(BODIES_CHOICE):
	@mkdir -p $(FITTED) && rm -f $(FITTED)/choice-bodies-* && touch $@

$(FITTED)/people.h5: $(OUT)/template.h5 $(CONFIG) $(BODIES_CHOICE)
	$(CHECK_DATA)
	$(FIT_STAGE) sample-bodies $(BIN)/sample-bodies $(RUN) --template $< $(MAKEHUMAN) \
	    $(if $(BODIES),--count $(BODIES)) --output $@

$(FITTED)/truth.h5: $(OUT)/template.h5 $(FITTED)/people.h5
	@rm -rf $(FITTED)/scans
	$(FIT_STAGE) simulate-scans $(BIN)/simulate-scans $(RUN) --template $< --skins $(FITTED)/people.h5 \
	    --scans $(FITTED)/scans --people $(FITTED)/people.json --output $@

$(FITTED)/skins.h5: $(OUT)/template.h5 $(FITTED)/truth.h5
	@rm -rf $(FITTED)/surfaces
	$(FIT_STAGE) fit-body $(BIN)/fit-body $(RUN) --template $< --scan $(FITTED)/scans --people $(FITTED)/people.json \
	    --truth $(FITTED)/truth.h5 --surfaces $(FITTED)/surfaces \
	    --report $(FITTED)/fits.json --min-passed 0.99 $(OUTSIDE) --output $@ | tee $(FITTED)/fits.txt

$(FITTED)/bodies.h5: $(OUT)/template.h5 $(FITTED)/skins.h5
	$(FIT_STAGE) build-layers $(BIN)/build-layers $(RUN) --template $< --skins $(FITTED)/skins.h5 $(OUTSIDE) --output $@ \
	    | tee $(FITTED)/layers.txt

$(FITTED)/report.txt: $(FITTED)/bodies.h5
	@{ echo "people from scans"; sed -n '/^truth of/,$$p' $(FITTED)/fits.txt; cat $(FITTED)/layers.txt; } | \
	    grep -v -e '^==' -e ' took ' > $@.tmp
	@awk -v bodies="$$(ls $(FITTED)/scans | wc -l)" '{ sum += $$1 } END { \
	    printf "fit-body and build-layers: %.0f s, %.2f s a body\n", sum, sum / bodies }' \
	    $(FITTED)/seconds/fit-body $(FITTED)/seconds/build-layers >> $@.tmp
	@mv $@.tmp $@

$(FITTED)/worst.png: $(FITTED)/skins.h5
	$(FIT_STAGE) picture-fit $(BIN)/picture-fit $(RUN) --report $(FITTED)/fits.json --surfaces $(FITTED)/surfaces --picture $@
