# SPDX-License-Identifier: Apache-2.0
# One scan of one's own: a layered body of it, and that body in a motion. Results go to out/<NAME>/.

SCAN ?=
NAME ?= $(basename $(notdir $(SCAN)))
AGE  ?=
METHOD     ?= fem
FRAME_RATE ?= 30

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
CLIP_CHOICE = $(CLIP)/choice-motion-$(firstword $(shell echo '$(OWN_MOTION) $(FRAME_RATE)' | md5sum))

.PHONY: body animate scan-given
scan-given:
	@test -n "$(SCAN)" || { echo "give SCAN=<file>: OBJ, PLY, OFF, STL or GLB (SEX=male|female, AGE=<years>, NAME=<name> too)" >&2; exit 2; }
	@test -z "$(word 2,$(SCAN))" || { echo "SCAN is one file, and its path holds no spaces: '$(SCAN)'" >&2; exit 2; }
	@for f in "$(SCAN)" $(OWN_MOTION); do test -e "$$f" || { echo "there is no file '$$f'" >&2; exit 2; }; done
	$(CHECK_DATA)
	@test ! -e "configs/$(NAME).json" -a "$(NAME)" != templates -a "$(NAME)" != bench || { echo "results would go among others in out/$(NAME)/: give NAME=<name>" >&2; exit 2; }

body: scan-given tools ## a layered body of one scan, out/<name>/{body.h5,report.txt,*.png}; SCAN=<file> [SEX=] [AGE=] [NAME=]
	@$(MAKE) --no-print-directory $(OWN)/report.txt $(OWN)/fit.png $(OWN)/body.png $(OWN)/section.png
	@cat $(OWN)/report.txt
	@echo "body: $(OWN)/body.h5; pictures: $(OWN)/fit.png, body.png, section.png"

animate: scan-given tools ## the body of one scan in a motion, out/<name>/<motion>/<method>.{h5,html,obj,pc2,png}; SCAN=<file> [MOTION=<file>] [METHOD=fem]
	@$(MAKE) --no-print-directory $(CLIP)/$(METHOD).html $(CLIP)/$(METHOD).pc2 $(CLIP)/$(METHOD).png
	@echo "page: $(CLIP)/$(METHOD).html, for any browser"
	@echo "animation: $(CLIP)/$(METHOD).obj moved by $(CLIP)/$(METHOD).pc2; frames: $(CLIP)/$(METHOD).png; flesh: $(CLIP)/$(METHOD).h5"

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
	    $(BIN)/ndg-info $< --template $(OWN_TEMPLATE) 2>&1 || test $$? = 3; } | sed '/^attributes/,/^measures/d' > $@.tmp
	@mv $@.tmp $@

$(OWN)/body.png: $(OWN)/body.h5
	$(OWN_STAGE) picture-layers $(BIN)/export-scene $(RUN) --template $(OWN_TEMPLATE) --bodies $< --picture-kind layers \
	    --height 700 --picture $@

$(OWN)/section.png: $(OWN)/body.h5
	$(OWN_STAGE) picture-section $(BIN)/export-scene $(RUN) --template $(OWN_TEMPLATE) --bodies $< --picture-kind section \
	    --count 1 --height 1800 --picture $@

$(CLIP_CHOICE):
	@mkdir -p $(CLIP) && rm -f $(CLIP)/choice-motion-* && touch $@

$(CLIP)/motion.h5: $(OWN_TEMPLATE) $(OWN_MOTION) $(CLIP_CHOICE)
	$(OWN_STAGE) import-motion $(BIN)/import-motion --force --template $< --joint-maps configs/joint-maps \
	    --joint-limits configs/joint-limits.json $(addprefix --motion ,$(OWN_MOTION)) --frame-rate $(FRAME_RATE) \
	    --report $(CLIP)/motion.json --output $@

OWN_SAMPLES = --template $(OWN_TEMPLATE) --bodies $(OWN)/body.h5 --poses $(CLIP)/motion.h5

# FEM by the tool that keeps every finished frame and goes on after an interruption.
$(CLIP)/fem.h5: $(OWN)/body.h5 $(CLIP)/motion.h5 $(CONFIG)
	$(OWN_STAGE) simulate-fem $(BIN)/simulate-fem $(RUN) $(OWN_SAMPLES) --body 0 --min-converged 0.9 --output $@

define OWN_PREDICTION
$(CLIP)/$(1).h5: $(OWN)/body.h5 $(CLIP)/motion.h5 $(filter-out --%,$(METHOD_FILES_$(1)))
	$(OWN_STAGE) $(1) $(BIN)/animate $(RUN) --method $(1) $(METHOD_FILES_$(1)) $(OWN_SAMPLES) --body 0 --output $$@
endef
$(foreach method,$(filter-out fem,$(METHOD)),$(eval $(call OWN_PREDICTION,$(method))))

# A mesh and what moves it.
$(CLIP)/%.pc2: $(CLIP)/%.h5
	$(OWN_STAGE) mesh $(BIN)/export-scene $(RUN) $(OWN_SAMPLES) --deformations $< --sample 0 --surface skin --mesh $(@:.pc2=.obj)
	$(OWN_STAGE) animation $(BIN)/export-scene $(RUN) $(OWN_SAMPLES) --deformations $< --sample 0 --frames 0 \
	    --surface skin --mesh $@

$(CLIP)/%.html: $(CLIP)/%.h5
	$(OWN_STAGE) page $(BIN)/export-scene $(RUN) $(OWN_SAMPLES) --deformations $< --frames 0 --page $@

$(CLIP)/%.png: $(CLIP)/%.h5
	$(OWN_STAGE) picture-frames $(BIN)/export-scene $(RUN) $(OWN_SAMPLES) --deformations $< --picture-kind frames --count 6 \
	    --colour volume --view three-quarter --height 500 --picture $@
endif
