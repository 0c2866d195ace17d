# SPDX-License-Identifier: Apache-2.0
# An avatar of soft tissue in a motion, with inertia: vertices over time and a GLB.

DYNAMICS_MOTION ?= configs/motions/run.json
# Frames a second; divides the 120 steps.
DYNAMICS_RATE ?= 30
# JSON with gravity and loads (docs/formats.md, Scenes); empty: none.
SCENE ?=
DYNAMICS_AVATAR = $(OUT)/avatar/$(firstword $(AVATAR)).h5
DYNAMICS = $(OUT)/dynamics

.PHONY: dynamics
dynamics: dynamics-tools ## an avatar's soft tissue in motion with inertia, out/<preset>/dynamics/{dynamics.h5,motion.glb,frames.png}; [AVATAR=body_0000 DYNAMICS_MOTION=<file> SCENE=<file>]
	@$(MAKE) --no-print-directory $(DYNAMICS)/dynamics.h5
	@echo "$(DYNAMICS)/motion.glb, $(DYNAMICS)/frames.png"

DYNAMICS_CHOICE = $(DYNAMICS)/choice-$(firstword $(shell echo '$(DYNAMICS_MOTION) $(DYNAMICS_RATE) $(SCENE) $(AVATAR)' | md5sum))
$(DYNAMICS_CHOICE):
	@mkdir -p $(DYNAMICS) && rm -f $(DYNAMICS)/choice-* && touch $@

# At the step rate: what lies between poses is interpolated linearly, and flesh feels every kink.
$(DYNAMICS)/motion.h5: $(OUT)/template.h5 $(DYNAMICS_MOTION) $(DYNAMICS_CHOICE)
	$(STAGE) dynamics-motion $(BIN)/import-motion --force --template $< --joint-maps configs/joint-maps \
	    --joint-limits configs/joint-limits.json --motion $(DYNAMICS_MOTION) --frame-rate 120 --interpolate --output $@

$(DYNAMICS)/dynamics.h5: $(DYNAMICS_AVATAR) $(DYNAMICS)/motion.h5 $(SCENE) $(call OPTIONS_OF,simulate-dynamics)
	$(STAGE) simulate-dynamics $(BIN)/simulate-dynamics $(RUN) --avatar $(DYNAMICS_AVATAR) --poses $(DYNAMICS)/motion.h5 \
	    $(if $(SCENE),--scene $(SCENE)) --frame-rate $(DYNAMICS_RATE) --output $@ --mesh $(DYNAMICS)/motion.glb --picture $(DYNAMICS)/frames.png
