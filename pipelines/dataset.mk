# SPDX-License-Identifier: Apache-2.0
# Bodies, poses, splits and FEM samples.

# Where bodies come from: MakeHuman with BodyParts3D's anatomy when a data folder is given, otherwise the procedural body
# and the built-in motions.
SOURCE ?= $(if $(DATA),anatomy,procedural)
SEX    ?= male
MOTION ?= $(if $(DATA),$(DATA)/motion) configs/motions

MOTION_LICENCE ?= $(if $(DATA),Captured motions: each under the licence its folder states. )Built-in motions: Apache-2.0

CHECK_DATA = @test "$(SOURCE)" = procedural || for d in makehuman bodyparts3d; do test -d "$(DATA)/$$d" || { \
    echo "SOURCE=$(SOURCE) needs DATA=<folder> with makehuman/ and bodyparts3d/ in it; there is no '$(DATA)/$$d'" \
    "(docs/data.md says where they come from; SOURCE=procedural needs no data)." >&2; exit 2; }; done
MAKEHUMAN = $(if $(filter anatomy,$(SOURCE)),--makehuman "$(DATA)/makehuman")
BODYPARTS3D = $(if $(filter anatomy,$(SOURCE)),--bodyparts3d "$(DATA)/bodyparts3d")
STAGE = @pipelines/stage.sh $(OUT)
# Bodies outside of published ranges are named; empty: they are left out as well, and the make ends when there are any.
OUTSIDE ?= --keep-outside
RUN = --config $(CONFIG) --force

.PHONY: templates poses dataset

templates: pipeline-tools ## templates of every source and size with their checks, out/templates/<source>-<sex>-<preset>.{h5,txt}
	$(if $(DATA),,@echo "without DATA=<folder> only the procedural body is built")
	@$(MAKE) --no-print-directory $(TEMPLATE_CHECKS)
	@tail -n +1 $(TEMPLATE_CHECKS)
poses: pipeline-tools ## motion capture on our skeleton and its farthest-point subset, out/<preset>/poses.{h5,png}
	@$(MAKE) --no-print-directory $(OUT)/poses.h5 $(OUT)/poses.png
dataset: pipeline-tools ## FEM samples, out/<preset>/fem.h5
	@$(MAKE) --no-print-directory $(OUT)/fem.h5

# Files that stand for a choice of source and motions: another choice makes what depends on it anew.
SOURCE_CHOICE = $(OUT)/choice-source-$(SOURCE)-$(SEX)
MOTION_CHOICE = $(OUT)/choice-motion-$(firstword $(shell echo '$(MOTION)' | md5sum))
$(SOURCE_CHOICE):
	@mkdir -p $(OUT) && rm -f $(OUT)/choice-source-* && touch $@
$(MOTION_CHOICE):
	@mkdir -p $(OUT) && rm -f $(OUT)/choice-motion-* && touch $@

# What a tool's options are in this preset: a change of the preset repeats the stages whose options it changes and what
# depends on them, nothing else.
$(OUT)/options/%.json: $(CONFIG)
	@mkdir -p $(@D) && $(BIN)/$* --config $(CONFIG) --print-config > $@.new
	@if cmp -s $@.new $@; then rm $@.new; else mv $@.new $@; fi
OPTIONS_OF = $(OUT)/options/$(1).json

# PAIRS=<n>: so many training pairs, and an eighth of that each to validate and to test.
PAIRS ?=
PAIRS_CHOICE = $(OUT)/choice-pairs-$(or $(PAIRS),preset)
PAIR_COUNTS = $(if $(PAIRS),--train-pairs $(PAIRS) --validation-pairs $$(( ($(PAIRS) + 7) / 8 )) --test-pairs $$(( ($(PAIRS) + 7) / 8 )))
$(PAIRS_CHOICE):
	@mkdir -p $(OUT) && rm -f $(OUT)/choice-pairs-* && touch $@

$(OUT)/template.h5: $(call OPTIONS_OF,make-template) $(SOURCE_CHOICE)
	$(CHECK_DATA)
	$(STAGE) template $(BIN)/make-template $(RUN) --source $(SOURCE) --sex $(SEX) $(MAKEHUMAN) $(BODYPARTS3D) --output $@

$(OUT)/skins.h5: $(OUT)/template.h5 $(call OPTIONS_OF,sample-bodies)
	$(CHECK_DATA)
	$(STAGE) sample-bodies $(BIN)/sample-bodies $(RUN) --template $< $(MAKEHUMAN) --output $@

$(OUT)/bodies.h5: $(OUT)/template.h5 $(OUT)/skins.h5 $(call OPTIONS_OF,build-layers)
	$(STAGE) build-layers $(BIN)/build-layers $(RUN) --template $(OUT)/template.h5 --skins $(OUT)/skins.h5 $(OUTSIDE) --output $@

$(OUT)/motion.h5: $(OUT)/template.h5 $(call OPTIONS_OF,import-motion) $(MOTION_CHOICE)
	$(STAGE) import-motion $(BIN)/import-motion $(RUN) --template $< --joint-maps configs/joint-maps \
	    --joint-limits configs/joint-limits.json $(addprefix --motion ,$(MOTION)) --report $(OUT)/motion.json \
	    --licence "$(MOTION_LICENCE)" --output $@

$(OUT)/poses.h5: $(OUT)/motion.h5 $(OUT)/template.h5 $(call OPTIONS_OF,sample-poses)
	$(STAGE) sample-poses $(BIN)/sample-poses $(RUN) --poses $< --template $(OUT)/template.h5 \
	    --joint-limits configs/joint-limits.json --range-of-motion $(OUT)/range_of_motion.json --output $@

$(OUT)/poses.png: $(OUT)/poses.h5 $(OUT)/bodies.h5
	$(STAGE) picture-poses $(BIN)/export-scene $(RUN) --template $(OUT)/template.h5 --bodies $(OUT)/bodies.h5 --poses $< \
	    --picture-kind poses --count 150 --view three-quarter --picture $@

$(OUT)/splits.h5: $(OUT)/template.h5 $(OUT)/bodies.h5 $(OUT)/poses.h5 $(call OPTIONS_OF,make-splits) $(PAIRS_CHOICE)
	$(STAGE) make-splits $(BIN)/make-splits $(RUN) $(PAIR_COUNTS) --template $(OUT)/template.h5 --bodies $(OUT)/bodies.h5 \
	    --poses $(OUT)/poses.h5 --output $@

BODY_FILES = --template $(OUT)/template.h5 --bodies $(OUT)/bodies.h5 --poses $(OUT)/poses.h5
BODY_DEPS = $(OUT)/template.h5 $(OUT)/bodies.h5 $(OUT)/poses.h5

$(OUT)/fem.h5: $(BODY_DEPS) $(OUT)/splits.h5 $(call OPTIONS_OF,simulate-fem)
	$(STAGE) simulate-fem $(BIN)/simulate-fem --config $(CONFIG) --force $(BODY_FILES) --splits $(OUT)/splits.h5 --output $@

# All templates: every source at the three sizes; SEXES="male female" makes both.
SEXES ?= male
TEMPLATE_NAMES = $(foreach source,$(if $(DATA),anatomy) procedural,$(foreach sex,$(SEXES),$(foreach size,demo desk paper,$(source)-$(sex)-$(size))))
TEMPLATE_CHECKS = $(TEMPLATE_NAMES:%=out/templates/%.txt)
template_part = $(word $(1),$(subst -, ,$(basename $(notdir $(2)))))
out/templates/%.h5: configs/demo.json configs/desk.json configs/paper.json
	@pipelines/stage.sh out/templates $* $(BIN)/make-template --config configs/$(call template_part,3,$@).json --force \
	    --source $(call template_part,1,$@) --sex $(call template_part,2,$@) --output $@ \
	    $(if $(findstring anatomy,$*),--makehuman "$(DATA)/makehuman" --bodyparts3d "$(DATA)/bodyparts3d")
out/templates/%.txt: out/templates/%.h5
	@$(BIN)/ndg-info $< > $@ || { cat $@; exit 3; }
