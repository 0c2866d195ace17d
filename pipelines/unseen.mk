# SPDX-License-Identifier: Apache-2.0
# Table 2: a body outside the training distribution in all test poses.

# One scan of one's own, or a stylised body made of the first person of the dataset.
UNSEEN_SCAN ?=
EXAGGERATION ?= $(or $(EXAGGERATION_$(PRESET)),1.8)
# At 1.8 the armpits of that person hold no valid layers.
EXAGGERATION_desk = 1.5

.PHONY: table-2
table-2: tools ## the networks on a body outside the training distribution, out/<preset>/unseen/, and all tables; UNSEEN_SCAN=<file>
	@$(MAKE) --no-print-directory tables TABLE_2=yes

UNSEEN = $(OUT)/unseen
UNSEEN_CHOICE = $(UNSEEN)/choice-$(firstword $(shell echo '$(UNSEEN_SCAN) $(EXAGGERATION)' | md5sum))
$(UNSEEN_CHOICE):
	@mkdir -p $(UNSEEN) && rm -f $(UNSEEN)/choice-* && touch $@

$(UNSEEN)/skins.h5: $(OUT)/template.h5 $(OUT)/skins.h5 $(UNSEEN_SCAN) $(UNSEEN_CHOICE)
	$(if $(UNSEEN_SCAN),$(STAGE) unseen-skin $(BIN)/fit-body $(RUN) --template $< --scan $(UNSEEN_SCAN) --keep-outside --output $@,\
	    $(STAGE) unseen-skin $(BIN)/exaggerate-body $(RUN) --template $< --skins $(OUT)/skins.h5 --factor $(EXAGGERATION) --output $@)

$(UNSEEN)/bodies.h5: $(OUT)/template.h5 $(UNSEEN)/skins.h5 $(call OPTIONS_OF,build-layers)
	$(STAGE) unseen-layers $(BIN)/build-layers $(RUN) --template $< --skins $(UNSEEN)/skins.h5 --keep-outside --output $@

UNSEEN_FILES = --template $(OUT)/template.h5 --bodies $(UNSEEN)/bodies.h5 --poses $(OUT)/poses.h5
UNSEEN_DEPS = $(OUT)/template.h5 $(UNSEEN)/bodies.h5 $(OUT)/poses.h5 $(UNSEEN)/splits.h5

$(UNSEEN)/splits.h5: $(OUT)/template.h5 $(UNSEEN)/bodies.h5 $(OUT)/poses.h5 $(OUT)/splits.h5
	$(STAGE) unseen-splits $(BIN)/make-splits --force $(UNSEEN_FILES) --unseen-of $(OUT)/splits.h5 --output $@

$(UNSEEN)/fem.h5: $(UNSEEN_DEPS) $(call OPTIONS_OF,simulate-fem)
	$(STAGE) unseen-fem $(BIN)/simulate-fem $(RUN) $(UNSEEN_FILES) --splits $(UNSEEN)/splits.h5 --min-converged 0.5 --output $@

define UNSEEN_PREDICTION
$(UNSEEN)/$(1).h5: $(UNSEEN_DEPS) $(filter-out --%,$(METHOD_FILES_$(1)))
	$(STAGE) unseen-$(1) $(BIN)/animate $(RUN) --method $(1) $(METHOD_FILES_$(1)) $(UNSEEN_FILES) \
	    --splits $(UNSEEN)/splits.h5 --output $$@
endef
$(foreach method,ndg vertexnet,$(eval $(call UNSEEN_PREDICTION,$(method))))

$(UNSEEN)/tables.json: $(UNSEEN)/fem.h5 $(UNSEEN)/ndg.h5 $(UNSEEN)/vertexnet.h5
	$(STAGE) unseen-metrics $(BIN)/evaluate-metrics $(RUN) $(UNSEEN_FILES) --splits $(UNSEEN)/splits.h5 \
	    --reference $(UNSEEN)/fem.h5 --prediction $(UNSEEN)/ndg.h5 --prediction $(UNSEEN)/vertexnet.h5 --output $@

$(REPORT)/unseen.png: $(UNSEEN)/fem.h5 $(UNSEEN)/ndg.h5 $(UNSEEN)/vertexnet.h5
	$(STAGE) unseen-picture $(BIN)/export-scene $(RUN) $(UNSEEN_FILES) $(addprefix --deformations ,$^) \
	    --picture-kind frames --colour volume --height 500 --picture $@
