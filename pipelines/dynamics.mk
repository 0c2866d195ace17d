# SPDX-License-Identifier: Apache-2.0
# An avatar of soft tissue in a motion, with inertia: vertices over time, a GLB and a page; figures of such runs.

DYNAMICS_MOTION ?= configs/motions/run.json
# Frames a second; divides the 120 steps.
DYNAMICS_RATE ?= 30
# JSON with gravity, loads, obstacles and garments (docs/formats.md, Scenes); empty: none.
SCENE ?=
DYNAMICS_AVATAR = $(OUT)/avatar/$(firstword $(AVATAR)).h5
DYNAMICS = $(OUT)/dynamics

.PHONY: dynamics dynamics-report
dynamics: dynamics-tools ## an avatar's soft tissue in motion with inertia, out/<preset>/dynamics/{dynamics.h5,page.html,motion.glb,frames.png}; [AVATAR=body_0000 DYNAMICS_MOTION=<file> SCENE=<file>]
	@$(MAKE) --no-print-directory $(DYNAMICS)/dynamics.h5
	@echo "$(DYNAMICS)/page.html, $(DYNAMICS)/motion.glb, $(DYNAMICS)/frames.png"

DYNAMICS_CHOICE = $(DYNAMICS)/choice-$(firstword $(shell echo '$(DYNAMICS_MOTION) $(DYNAMICS_RATE) $(SCENE) $(AVATAR)' | md5sum))
$(DYNAMICS_CHOICE):
	@mkdir -p $(DYNAMICS) && rm -f $(DYNAMICS)/choice-* && touch $@

# At the step rate: what lies between poses is interpolated linearly, and flesh feels every kink.
AT_STEP_RATE = $(BIN)/import-motion --force --joint-maps configs/joint-maps --joint-limits configs/joint-limits.json \
    --frame-rate 120 --interpolate --template $(OUT)/template.h5

$(DYNAMICS)/motion.h5: $(OUT)/template.h5 $(DYNAMICS_MOTION) $(DYNAMICS_CHOICE)
	$(STAGE) dynamics-motion $(AT_STEP_RATE) --motion $(DYNAMICS_MOTION) --output $@

$(DYNAMICS)/dynamics.h5: $(DYNAMICS_AVATAR) $(DYNAMICS)/motion.h5 $(SCENE) $(call OPTIONS_OF,simulate-dynamics)
	$(STAGE) simulate-dynamics $(BIN)/simulate-dynamics $(RUN) --avatar $(DYNAMICS_AVATAR) --poses $(DYNAMICS)/motion.h5 \
	    $(if $(SCENE),--scene $(SCENE)) --frame-rate $(DYNAMICS_RATE) --output $@ --page $(DYNAMICS)/page.html \
	    --mesh $(DYNAMICS)/motion.glb --picture $(DYNAMICS)/frames.png

# The runs of configs/dynamics-figures.json. Of each: its motion, and what else it is told.
FIGURES = $(DYNAMICS)/figures
FIGURE_RUNS = hold-unposed hold-world belly-half-fung belly-two-fung belly-half-neo belly-two-neo arm-half-fung \
    arm-two-fung arm-half-neo arm-two-neo sleeve ball sitting crossed-arms
$(FIGURE_RUNS:%=$(FIGURES)/%.h5): POSED = stand
$(FIGURES)/hold-unposed.h5 $(FIGURES)/hold-world.h5: POSED = sit_down
$(FIGURES)/hold-unposed.h5 $(FIGURES)/hold-world.h5: TOLD = --hold 2
$(FIGURES)/hold-world.h5: OTHERWISE = --deformation-space world
# So soft that the weights reach the strains at which the laws differ.
SOFT = --young-normal 2000 --young-tangent 2000
$(FIGURES)/belly-half-%.h5: TOLD = $(SOFT) --hold 1.2 --scene configs/scenes/belly_half_kilogram.json
$(FIGURES)/belly-two-%.h5: TOLD = $(SOFT) --hold 1.2 --scene configs/scenes/belly_two_kilograms.json
$(FIGURES)/arm-half-%.h5: TOLD = $(SOFT) --hold 1.2 --scene configs/scenes/arm_half_kilogram.json
$(FIGURES)/arm-two-%.h5: TOLD = $(SOFT) --hold 1.2 --scene configs/scenes/arm_two_kilograms.json
$(FIGURES)/belly-half-neo.h5 $(FIGURES)/belly-two-neo.h5 $(FIGURES)/arm-half-neo.h5 $(FIGURES)/arm-two-neo.h5: OTHERWISE = --tissue-law neo-hookean
$(FIGURES)/sleeve.h5: TOLD = --hold 0.5 --scene configs/scenes/sleeve.json
$(FIGURES)/ball.h5: TOLD = --hold 0.4 --scene configs/scenes/ball.json
$(FIGURES)/sitting.h5: POSED = sit_down
$(FIGURES)/sitting.h5: TOLD = --scene configs/scenes/sitting.json
$(FIGURES)/crossed-arms.h5: POSED = cross_arms
$(FIGURES)/crossed-arms.h5: TOLD = --scene configs/scenes/crossed_arms.json

dynamics-report: dynamics-tools ## Figures 4, 5 and 6 of Romero et al. 2020 on an avatar, and its contact with things and itself, out/<preset>/dynamics/report/index.html
	@$(MAKE) --no-print-directory $(DYNAMICS)/report/index.html
	@echo "$(DYNAMICS)/report/index.html"

$(FIGURES)/motion-%.h5: configs/scenes/motions/%.json $(OUT)/template.h5
	@mkdir -p $(FIGURES)
	$(STAGE) figures-motion $(AT_STEP_RATE) --motion $< --output $@

$(FIGURE_RUNS:%=$(FIGURES)/%.h5): $(FIGURES)/%.h5: $(DYNAMICS_AVATAR) $(FIGURES)/motion-stand.h5 $(FIGURES)/motion-sit_down.h5 \
    $(FIGURES)/motion-cross_arms.h5 $(wildcard configs/scenes/*.json) $(call OPTIONS_OF,simulate-dynamics)
	@echo 'simulate-dynamics --avatar $(DYNAMICS_AVATAR) --poses $(FIGURES)/motion-$(POSED).h5 $(TOLD) $(OTHERWISE) --output $@' > $(FIGURES)/$*.txt
	$(STAGE) figures-$* $(BIN)/simulate-dynamics $(RUN) --avatar $(DYNAMICS_AVATAR) --poses $(FIGURES)/motion-$(POSED).h5 $(TOLD) $(OTHERWISE) --output $@

$(DYNAMICS)/report/index.html: $(DYNAMICS_AVATAR) configs/dynamics-figures.json $(FIGURE_RUNS:%=$(FIGURES)/%.h5)
	@mkdir -p $(DYNAMICS)/report
	$(STAGE) dynamics-report $(BIN)/report-dynamics --force --avatar $(DYNAMICS_AVATAR) --figures configs/dynamics-figures.json \
	    --runs $(FIGURES) --output $@
