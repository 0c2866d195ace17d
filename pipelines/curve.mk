# SPDX-License-Identifier: Apache-2.0
# The learning curve: networks trained on the first samples of the training split, all with the preset's epochs.

# Numbers of training samples.
CURVE ?= $(CURVE_$(PRESET))
CURVE_smoke = 8 32
CURVE_demo = 50 200 800
CURVE_desk = 500 2000 8000
CURVE_paper = 1250 5000 20000

.PHONY: learning-curve
learning-curve: tools ## Table 1's measures against the number of samples, out/<preset>/curve/{results.md,tables.json}; CURVE="500 2000 8000"
	@$(MAKE) --no-print-directory $(OUT)/curve/tables.json
	@cat $(OUT)/curve/results.md

CURVE_POINTS = $(foreach network,ndg vertexnet,$(CURVE:%=$(network)-%))
CURVE_ROW_ndg = NDG
CURVE_ROW_vertexnet = VertexNet

define CURVE_POINT
$(OUT)/curve/$(1)-$(2)-model.h5: $(BODY_DEPS) $(OUT)/fem.h5 $(OUT)/shape_space.h5 $(call OPTIONS_OF,train-ndg)
	@mkdir -p $(OUT)/curve && rm -f $$@
	$(STAGE) train-$(1)-$(2) $(BIN)/train-ndg --config $(CONFIG) $(BODY_FILES) --samples $(OUT)/fem.h5 \
	    --shape-space $(OUT)/shape_space.h5 $(TRAIN_$(1)) $(ON_DEVICE) --max-samples $(2) --output $$@
$(OUT)/curve/$(1)-$(2).h5: $(BODY_DEPS) $(OUT)/splits.h5 $(OUT)/curve/$(1)-$(2)-model.h5
	$(STAGE) $(1)-$(2) $(BIN)/animate $(RUN) --method $(1) --model $(OUT)/curve/$(1)-$(2)-model.h5 \
	    --name "$(CURVE_ROW_$(1)), $(2) samples" $(ON_DEVICE) $(BODY_FILES) $(TEST_PAIRS) --output $$@
endef
$(foreach network,ndg vertexnet,$(foreach count,$(CURVE),$(eval $(call CURVE_POINT,$(network),$(count)))))

$(OUT)/curve/tables.json: $(BODY_DEPS) $(OUT)/splits.h5 $(OUT)/fem.h5 $(CURVE_POINTS:%=$(OUT)/curve/%.h5)
	$(STAGE) evaluate-curve $(BIN)/evaluate-metrics $(RUN) $(BODY_FILES) $(TEST_PAIRS) --reference $(OUT)/fem.h5 \
	    $(CURVE_POINTS:%=--prediction $(OUT)/curve/%.h5) --output $@
