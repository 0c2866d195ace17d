# SPDX-License-Identifier: Apache-2.0
# One scan of one's own: a layered body of it, and that body in a motion. Results go to out/<NAME>/.

SCAN ?=
NAME ?= $(basename $(notdir $(SCAN)))
AGE  ?=
METHOD     ?= fem
FRAME_RATE ?= 30
# Extension of the animated mesh, of those that export-scene --help lists; .pc2 comes with the .obj that it moves.
MESH       ?= pc2
# Of a rig that configs/joint-maps does not know, as propose-joint-map writes it.
JOINT_MAP  ?=

OWN = out/$(NAME)
OWN_STAGE = @pipelines/stage.sh $(OWN)
# Sex and age are remembered, so that a body stays as it is when its animation does not tell them again. Without SEX the
# template is a man's and formulas of both sexes are blended.
OWN_SEX := $(if $(filter file,$(origin SEX)),$(shell cat '$(OWN)/sex' 2> /dev/null),$(SEX))
OWN_AGE := $(or $(AGE),$(shell cat '$(OWN)/age' 2> /dev/null))
PERSON = $(if $(OWN_SEX),--sex $(if $(filter female,$(OWN_SEX)),0,1)) $(if $(OWN_AGE),--age-years $(OWN_AGE))
# A method that needs files of a training (eval.mk) takes the template of that training, all others one for all scans.
OWN_TEMPLATE = $(if $(METHOD_FILES_$(METHOD)),$(OUT)/template.h5,out/templates/$(SOURCE)-$(or $(OWN_SEX),$(SEX))-$(PRESET).h5)
OWN_CHOICE = $(OWN)/choice-scan-$(firstword $(shell echo '$(SCAN) $(PERSON) $(OWN_TEMPLATE)' | md5sum))

# Motions of the project unless one is given.
OWN_MOTION = $(if $(filter file,$(origin MOTION)),configs/motions/squat.json,$(MOTION))
CLIP = $(OWN)/$(basename $(notdir $(firstword $(OWN_MOTION))))
OWN_MESHES = $(CLIP)/$(METHOD).$(MESH) $(if $(filter pc2,$(MESH)),$(CLIP)/$(METHOD).obj)
CLIP_CHOICE = $(CLIP)/choice-motion-$(firstword $(shell echo '$(OWN_MOTION) $(FRAME_RATE) $(JOINT_MAP)' | md5sum))

.PHONY: body animate scan-given
scan-given:
	@test -n "$(SCAN)" || { echo "give SCAN=<file>: OBJ, PLY, OFF, STL or GLB (SEX=male|female, AGE=<years>, NAME=<name> too)" >&2; exit 2; }
	@for f in "$(SCAN)" $(OWN_MOTION) $(JOINT_MAP); do test -e "$$f" || { echo "there is no file '$$f'" >&2; exit 2; }; done
	$(CHECK_DATA)
	@test ! -e "configs/$(NAME).json" -a "$(NAME)" != templates -a "$(NAME)" != bench || { echo "results would go among others in out/$(NAME)/: give NAME=<name>" >&2; exit 2; }

body: scan-given tools ## a layered body of one scan, out/<name>/{body.h5,report.txt,*.png}; SCAN=<file> [SEX=] [AGE=] [NAME=]
	@$(MAKE) --no-print-directory $(OWN)/report.txt $(OWN)/fit.png $(OWN)/body.png $(OWN)/section.png
	@cat $(OWN)/report.txt
	@echo "body: $(OWN)/body.h5; pictures: $(OWN)/fit.png, body.png, section.png"

animate: scan-given tools ## the body of one scan in a motion, out/<name>/<motion>/<method>.{h5,html,pc2,obj,png}; SCAN=<file> [MOTION=<file>] [METHOD=fem] [FRAME_RATE=30] [MESH=pc2] [JOINT_MAP=<file>]
	@$(MAKE) --no-print-directory $(CLIP)/$(METHOD).html $(CLIP)/$(METHOD).png $(OWN_MESHES)
	@echo "page: $(CLIP)/$(METHOD).html, for any browser"
	@echo "animation: $(OWN_MESHES); frames: $(CLIP)/$(METHOD).png; flesh: $(CLIP)/$(METHOD).h5"

ifneq ($(SCAN),)
$(OWN_CHOICE):
	@mkdir -p $(OWN) && rm -f $(OWN)/choice-scan-* && touch $@
	@printf '%s' '$(OWN_SEX)' > $(OWN)/sex && printf '%s' '$(OWN_AGE)' > $(OWN)/age

$(OWN)/skin.h5: $(OWN_TEMPLATE) $(SCAN) $(CONFIG) $(OWN_CHOICE)
	$(OWN_STAGE) fit-body $(BIN)/fit-body $(RUN) --template $< --scan $(SCAN) $(PERSON) --keep-outside \
	    --surfaces $(OWN)/surfaces --report $(OWN)/fit.json --output $@ | tee $(OWN)/fit.txt

$(OWN)/fit.png: $(OWN)/skin.h5
	$(OWN_STAGE) picture-fit $(BIN)/picture-fit $(RUN) --report $(OWN)/fit.json --surfaces $(OWN)/surfaces --picture $@

$(OWN)/body.h5: $(OWN_TEMPLATE) $(OWN)/skin.h5 $(CONFIG)
	$(OWN_STAGE) build-layers $(BIN)/build-layers $(RUN) --template $< --skins $(OWN)/skin.h5 --keep-outside --output $@ \
	    | tee $(OWN)/layers.txt

# A body outside of published ranges is named in its report, and is still its owner's.
$(OWN)/report.txt: $(OWN)/body.h5
	@{ cat $(OWN)/fit.txt $(OWN)/layers.txt | grep -v -e '^==' -e ' took ' -e ' is outside: '; \
	    $(BIN)/ndg-info $< --template $(OWN_TEMPLATE) 2>&1 || test $$? = 3; } | sed '/^what  /,/^measures/d' > $@.tmp
	@mv $@.tmp $@

$(OWN)/body.png: $(OWN)/body.h5
	$(OWN_STAGE) picture-layers $(BIN)/export-scene $(RUN) --template $(OWN_TEMPLATE) --bodies $< --picture-kind layers \
	    --height 700 --picture $@

$(OWN)/section.png: $(OWN)/body.h5
	$(OWN_STAGE) picture-section $(BIN)/export-scene $(RUN) --template $(OWN_TEMPLATE) --bodies $< --picture-kind section \
	    --count 1 --height 1800 --picture $@

$(CLIP_CHOICE):
	@mkdir -p $(CLIP) && rm -f $(CLIP)/choice-motion-* && touch $@

OWN_ANIMATION = --template $(OWN_TEMPLATE) --bodies $(OWN)/body.h5
OWN_RIG = --joint-maps configs/joint-maps
ifneq ($(JOINT_MAP),)
OWN_RIG = --joint-map $(JOINT_MAP)
endif
OWN_MOTIONS = $(OWN_RIG) --joint-limits configs/joint-limits.json $(addprefix --motion ,$(OWN_MOTION)) --frame-rate $(FRAME_RATE)

# The mesh that a .pc2 moves; only its triangles count.
$(CLIP)/%.obj: $(OWN)/body.h5 $(CLIP_CHOICE)
	$(OWN_STAGE) mesh $(BIN)/export-scene $(RUN) $(OWN_ANIMATION) --surface skin --mesh $@

# FEM by the tool that keeps every finished frame and goes on after an interruption, which needs the poses in a file.
$(CLIP)/motion.h5: $(OWN_TEMPLATE) $(OWN_MOTION) $(JOINT_MAP) $(CLIP_CHOICE)
	$(OWN_STAGE) import-motion $(BIN)/import-motion --force --template $< $(OWN_MOTIONS) --interpolate \
	    --report $(CLIP)/motion.json --output $@

$(CLIP)/fem.h5: $(OWN)/body.h5 $(CLIP)/motion.h5 $(CONFIG)
	$(OWN_STAGE) simulate-fem $(BIN)/simulate-fem $(RUN) $(OWN_ANIMATION) --poses $(CLIP)/motion.h5 --body 0 \
	    --min-converged 0.9 --output $@

$(CLIP)/fem.html $(CLIP)/fem.$(MESH) $(CLIP)/fem.png &: $(CLIP)/fem.h5
	$(OWN_STAGE) show $(BIN)/export-scene $(RUN) $(OWN_ANIMATION) --poses $(CLIP)/motion.h5 --deformations $< --sample 0 \
	    --frames 0 --surface skin --page $(CLIP)/fem.html --mesh $(CLIP)/fem.$(MESH) --picture $(CLIP)/fem.png \
	    --picture-kind frames --count 6 --colour volume --view three-quarter --height 500

define OWN_PREDICTION
$(CLIP)/$(1).html $(CLIP)/$(1).$(MESH) $(CLIP)/$(1).png $(CLIP)/$(1).h5 &: $(OWN)/body.h5 $(OWN_MOTION) $(JOINT_MAP) $(CLIP_CHOICE) \
    $(filter-out --%,$(METHOD_FILES_$(1)))
	$(OWN_STAGE) $(1) $(BIN)/animate $(RUN) --method $(1) $(METHOD_FILES_$(1)) $(OWN_ANIMATION) $(OWN_MOTIONS) \
	    --output $(CLIP)/$(1).h5 --surface skin --page $(CLIP)/$(1).html --mesh $(CLIP)/$(1).$(MESH) --picture $(CLIP)/$(1).png \
	    --volume-colours --view three-quarter --height 500
endef
$(foreach method,$(filter-out fem,$(METHOD)),$(eval $(call OWN_PREDICTION,$(method))))
endif
