# SPDX-License-Identifier: Apache-2.0
# Shape space, linear correctives and networks.

.PHONY: train
train: pipeline-tools ## train the networks of Table 1, out/<preset>/model.h5 and vertexnet-model.h5
	@$(MAKE) --no-print-directory $(OUT)/model.h5 $(OUT)/vertexnet-model.h5

$(OUT)/shape_space.h5: $(OUT)/template.h5 $(OUT)/bodies.h5 $(OUT)/splits.h5 $(call OPTIONS_OF,fit-shape-space)
	$(STAGE) fit-shape-space $(BIN)/fit-shape-space $(RUN) --template $(OUT)/template.h5 --bodies $(OUT)/bodies.h5 \
	    --splits $(OUT)/splits.h5 --output $@

$(OUT)/correctives.h5: $(BODY_DEPS) $(OUT)/fem.h5 $(call OPTIONS_OF,fit-correctives)
	$(STAGE) fit-correctives $(BIN)/fit-correctives $(RUN) $(BODY_FILES) --samples $(OUT)/fem.h5 --output $@

# What a network is beside the preset's train-ndg: same trunk, same training. VertexNet's decoder: 680 modes or 99.5 %
# of the variance, whichever is reached first; it needs about twice the epochs (212 to NDG's 102 in NDG 5.2.1).
TRAIN_vertexnet = --output-space vertex-offsets --output-basis 680 --output-basis-variance 0.995 \
    --epochs $(or $(VERTEXNET_EPOCHS_$(PRESET)),120)
VERTEXNET_EPOCHS_demo = 48
VERTEXNET_EPOCHS_paper = 212

# Variants: ablations (NDG Table 4), other parametrisations (NDG 4.4), training without the samples that augmentation
# adds, and what is beyond the paper: fixed bases, a network for each region, averages of weights.
KNOWN_VARIANTS = no-exponential no-rotation no-shape lu qr not-augmented $(BEYOND_PAPER)
BEYOND_PAPER = fixed-basis regional regional-fixed-basis averaged regional-averaged vertexnet-regional
TRAIN_no-exponential = --parametrisation direct
# Gradients without R_p cannot be spliced: to be compared with not-augmented.
TRAIN_no-rotation = --no-rotation --no-mirror --splice 0
TRAIN_no-shape = --no-shape
TRAIN_lu = --parametrisation lu
TRAIN_qr = --parametrisation qr
TRAIN_not-augmented = --no-mirror --splice 0
AVERAGED = --weight-average 0.998
# In the space of coefficients epochs are cheap: more of them.
TRAIN_fixed-basis = --parametrisation direct --output-basis 600 --epochs 60 $(AVERAGED)
# Twenty regions, of a twentieth of the flesh each: small networks.
TRAIN_regional = --region-reach 3 --widths 256,256,64
TRAIN_regional-fixed-basis = --region-reach 3 $(or $(REGIONAL_BASIS_$(PRESET)),--widths 256,256 --output-basis 64) \
    --parametrisation direct --epochs 60 $(AVERAGED)
REGIONAL_BASIS_desk = --widths 384,384 --output-basis 192
TRAIN_averaged = $(AVERAGED)
TRAIN_regional-averaged = $(TRAIN_regional) $(AVERAGED)
TRAIN_vertexnet-regional = --output-space vertex-offsets --output-basis 64 --output-basis-variance 0.995 --region-reach 3 \
    --widths 256,256 --epochs 60 $(AVERAGED)

ON_DEVICE = $(if $(DEVICE),--device $(DEVICE))

# Without --force a killed training goes on from its checkpoint.
define NETWORK
$(OUT)/$(2)model.h5: $(BODY_DEPS) $(OUT)/fem.h5 $(OUT)/shape_space.h5 $(call OPTIONS_OF,train-ndg)
	@rm -f $$@ $$(@:.h5=.png)
	$(STAGE) train-$(1) $(BIN)/train-ndg --config $(CONFIG) $(BODY_FILES) --samples $(OUT)/fem.h5 \
	    --shape-space $(OUT)/shape_space.h5 $(TRAIN_$(1)) $(ON_DEVICE) --output $$@ --picture $$(@:.h5=.png)
endef
$(eval $(call NETWORK,ndg,))
$(foreach name,vertexnet $(KNOWN_VARIANTS),$(eval $(call NETWORK,$(name),$(name)-)))

.PHONY: torchscript
torchscript: pipeline-tools ## the networks of Table 1 for Python, out/<preset>/{model,vertexnet-model}.pt: torch.jit.load
	@$(MAKE) --no-print-directory $(OUT)/model.pt $(OUT)/vertexnet-model.pt

$(OUT)/%.pt: $(OUT)/%.h5 $(OUT)/template.h5
	$(STAGE) torchscript-$* $(BIN)/export-network $(RUN) --model $< --template $(OUT)/template.h5 --output $@
