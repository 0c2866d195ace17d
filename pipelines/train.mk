# SPDX-License-Identifier: Apache-2.0
# Shape space and network.

.PHONY: train
train: build ## train the network, out/<preset>/model.h5
	@$(MAKE) --no-print-directory $(OUT)/model.h5

$(OUT)/shape_space.h5: $(OUT)/template.h5 $(OUT)/bodies.h5 $(OUT)/splits.h5 $(CONFIG)
	$(STAGE) fit-shape-space $(BIN)/fit-shape-space $(RUN) --template $(OUT)/template.h5 --bodies $(OUT)/bodies.h5 \
	    --splits $(OUT)/splits.h5 --output $@

# Without --force a killed training goes on from its checkpoint.
$(OUT)/model.h5: $(BODY_DEPS) $(OUT)/fem.h5 $(OUT)/shape_space.h5 $(CONFIG)
	@rm -f $@
	$(STAGE) train-ndg $(BIN)/train-ndg --config $(CONFIG) $(BODY_FILES) --samples $(OUT)/fem.h5 --shape-space $(OUT)/shape_space.h5 \
	    --output $@
