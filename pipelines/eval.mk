# SPDX-License-Identifier: Apache-2.0
# Predictions on the test split, Tables 1 to 4, pictures and a GLB.

.PHONY: tables make-tables ablations beyond-paper check-results
tables: make-tables ## Tables 1 and 3 and pictures, out/<preset>/report/{index.html,results.md,tables.json}
	$(NAME_RESULTS)

# What the stages of a preset take, where somebody has measured it.
EXPECTED_SECONDS = pipelines/seconds/$(PRESET)
# The stages that are out of date. Options are brought up to date before, so that a config that changes none repeats none.
OUTDATED_STAGES = $$($(MAKE) -n -o $(CONFIG) --no-print-directory $(OUT)/report/tables.json | sed -n 's,.*pipelines/stage.sh [^ ]* \([^ ]*\) .*,\1,p')
make-tables: pipeline-tools
	@$(if $(wildcard $(OUT)/options/*.json),$(MAKE) --no-print-directory --silent $(wildcard $(OUT)/options/*.json))
	@stages=($(OUTDATED_STAGES)); test $${#stages[@]} -eq 0 || pipelines/plan.sh $(OUT) $(EXPECTED_SECONDS) "$${stages[@]}"
	@NDG_PLAN=$(OUT)/plan $(MAKE) --no-print-directory $(OUT)/report/tables.json
	@cat $(OUT)/report/results.md

define NAME_RESULTS
	@echo "report: $(REPORT)/index.html"
	@echo "page:   $(REPORT)/page.html (a body in motion, in any browser)"
	@echo "GLB:    $(REPORT)/motion.glb (the same for other programs), posed.glb (a body in one pose)"
endef

ablations: build ## the same with the rows of Table 4: NDG without matrix exponential, body shape, rotation
	@$(MAKE) --no-print-directory tables VARIANTS="no-exponential no-shape not-augmented no-rotation"

beyond-paper: build ## the same with rows that are not in the paper: fixed bases, regional networks, averages of weights
	@$(MAKE) --no-print-directory tables VARIANTS="$(BEYOND_PAPER)"

EXPECTATIONS ?= configs/expectations/$(PRESET).json
check-results: pipeline-tools ## hold the tables of a run against configs/expectations/<preset>.json; exit code 3 where they differ
	@test -f "$(REPORT)/tables.json" || { echo "there is no $(REPORT)/tables.json: make tables PRESET=$(PRESET)" >&2; exit 2; }
	@test -f "$(EXPECTATIONS)" || { echo "there are no expectations of this preset, $(EXPECTATIONS)" >&2; exit 2; }
	@$(BIN)/check-results --tables $(REPORT)/tables.json --expectations $(EXPECTATIONS)

TEST_PAIRS = --splits $(OUT)/splits.h5 --split test
REPORT = $(OUT)/report

# The table of methods is the tool's. FEM is what the others are compared with, stored gradients are no method of their
# own, rigid parts move no flesh, and the runtime shows the same network. LEAVE_OUT=<methods>: not those either. Before the first build the list is empty;
# targets that need it are made by a second make.
LEAVE_OUT ?=
# Rows that `make demo` leaves to `make tables PRESET=demo`.
SLOWER_METHODS = projective-skinning corotated linear-correctives
METHODS := $(filter-out fem gradients rigid-parts runtime $(LEAVE_OUT),$(shell $(BIN)/animate --list-methods 2> /dev/null))
# Rows beside those of Table 1: variants (pipelines/train.mk), of Table 4 or beyond the paper.
VARIANTS ?=
METHOD_PREDICTIONS = $(METHODS:%=$(OUT)/%.h5)
TABLE_4 = $(patsubst %,$(OUT)/variant-%.h5,$(filter-out $(BEYOND_PAPER),$(VARIANTS)))
OTHER_ROWS = $(patsubst %,$(OUT)/variant-%.h5,$(filter $(BEYOND_PAPER),$(VARIANTS)))
PREDICTIONS = $(METHOD_PREDICTIONS) $(TABLE_4) $(OTHER_ROWS)
# Table 2 (pipelines/unseen.mk) where asked for.
TABLE_2 ?=
UNSEEN_TABLES = $(if $(TABLE_2),$(OUT)/unseen/tables.json)
# Folders of meshes of other models for Table 3 (docs/formats.md), each a row called like its folder.
EXTERNAL ?=

# What a method needs beside bodies and poses: METHOD_FILES_<method> = --<flag> <file> ...
METHOD_FILES_ndg = --model $(OUT)/model.h5
METHOD_FILES_vertexnet = --model $(OUT)/vertexnet-model.h5
METHOD_FILES_linear-correctives = --correctives $(OUT)/correctives.h5
METHOD_OPTIONS_ndg = $(ON_DEVICE)
METHOD_OPTIONS_vertexnet = $(ON_DEVICE)

define PREDICTION
$(OUT)/$(1).h5: $(BODY_DEPS) $(OUT)/splits.h5 $(filter-out --%,$(METHOD_FILES_$(1)))
	$(STAGE) $(1) $(BIN)/animate $(RUN) --method $(1) $(METHOD_FILES_$(1)) $(METHOD_OPTIONS_$(1)) $(BODY_FILES) $(TEST_PAIRS) --output $$@
endef
$(foreach method,$(METHODS),$(eval $(call PREDICTION,$(method))))

# Rows are named by what the model is; of those that only training tells apart, here.
ROW_not-augmented = --name "NDG not augmented"
ROW_averaged = --name "NDG, averaged weights"
ROW_regional-averaged = --name "NDG regional, averaged weights"
METHOD_OF_vertexnet-regional = vertexnet
define VARIANT
$(OUT)/variant-$(1).h5: $(BODY_DEPS) $(OUT)/splits.h5 $(OUT)/$(1)-model.h5
	$(STAGE) variant-$(1) $(BIN)/animate $(RUN) --method $(or $(METHOD_OF_$(1)),ndg) --model $(OUT)/$(1)-model.h5 \
	    $(ROW_$(1)) $(ON_DEVICE) $(BODY_FILES) $(TEST_PAIRS) --output $$@
endef
$(foreach variant,$(KNOWN_VARIANTS),$(eval $(call VARIANT,$(variant))))

$(REPORT)/layers.png: $(OUT)/template.h5 $(OUT)/bodies.h5
	$(STAGE) picture-layers $(BIN)/export-scene $(RUN) --template $(OUT)/template.h5 --bodies $(OUT)/bodies.h5 \
	    --picture-kind layers --picture $@

$(REPORT)/cut.png: $(OUT)/template.h5 $(OUT)/bodies.h5
	$(STAGE) picture-cut $(BIN)/export-scene $(RUN) --template $(OUT)/template.h5 --bodies $(OUT)/bodies.h5 \
	    --picture-kind cut --picture $@

$(REPORT)/bodies.png: $(OUT)/template.h5 $(OUT)/bodies.h5
	$(STAGE) picture-bodies $(BIN)/export-scene $(RUN) --template $(OUT)/template.h5 --bodies $(OUT)/bodies.h5 \
	    --picture-kind bodies --count 8 --picture $@

$(REPORT)/frames.png: $(BODY_DEPS) $(OUT)/fem.h5 $(PREDICTIONS)
	$(STAGE) picture-frames $(BIN)/export-scene $(RUN) $(BODY_FILES) $(addprefix --deformations ,$(OUT)/fem.h5 $(PREDICTIONS)) \
	    --picture-kind frames --colour volume --height 700 --picture $@

$(REPORT)/errors.png: $(OUT)/template.h5 $(OUT)/bodies.h5 $(OUT)/fem.h5 $(OUT)/ndg.h5 $(OUT)/vertexnet.h5
	$(STAGE) picture-errors $(BIN)/export-scene $(RUN) --template $(OUT)/template.h5 --bodies $(OUT)/bodies.h5 \
	    $(addprefix --deformations ,$(OUT)/fem.h5 $(OUT)/ndg.h5 $(OUT)/vertexnet.h5) --picture-kind errors --height 600 --picture $@

# The WORST=<n> worst samples of each method, beside FEM.
WORST ?= $(if $(filter demo smoke,$(PRESET)),0,5)
$(REPORT)/worst-%.png: $(OUT)/%.h5 $(BODY_DEPS) $(OUT)/fem.h5
	$(STAGE) picture-worst-$* $(BIN)/export-scene $(RUN) $(BODY_FILES) --deformations $(OUT)/fem.h5 --deformations $< \
	    --picture-kind worst --count $(WORST) --colour volume --height 400 --picture $@

$(REPORT)/posed.glb: $(BODY_DEPS) $(OUT)/ndg.h5
	$(STAGE) scene-glb $(BIN)/export-scene $(RUN) $(BODY_FILES) --deformations $(OUT)/ndg.h5 --sample 0 --mesh $@

$(OUT)/protrusion.json: $(BODY_DEPS) $(OUT)/splits.h5 $(OUT)/fem.h5 $(METHOD_PREDICTIONS) $(call OPTIONS_OF,measure-protrusion)
	$(STAGE) measure-protrusion $(BIN)/measure-protrusion $(RUN) $(BODY_FILES) $(TEST_PAIRS) \
	    $(addprefix --deformations ,$(OUT)/fem.h5 $(METHOD_PREDICTIONS)) $(addprefix --external ,$(EXTERNAL)) --output $@

PICTURES = $(addprefix $(REPORT)/,layers.png cut.png bodies.png frames.png errors.png posed.glb motion.glb page.html) \
    $(if $(TABLE_2),$(REPORT)/unseen.png) $(if $(filter-out 0,$(WORST)),$(METHODS:%=$(REPORT)/worst-%.png))

$(OUT)/seconds.json: $(PREDICTIONS) $(PICTURES) $(OUT)/protrusion.json
	@cd $(OUT)/seconds && for f in *; do printf '%s %s\n' "$$f" "$$(cat "$$f")"; done | \
	    awk 'BEGIN { printf "{" } { printf "%s\"%s\": %s", (NR > 1 ? ", " : ""), $$1, $$2 } END { print "}" }' > ../seconds.json

$(REPORT)/tables.json: $(BODY_DEPS) $(OUT)/splits.h5 $(OUT)/fem.h5 $(PREDICTIONS) $(OUT)/protrusion.json $(UNSEEN_TABLES) $(OUT)/seconds.json
	$(STAGE) evaluate-metrics $(BIN)/evaluate-metrics $(RUN) $(BODY_FILES) $(TEST_PAIRS) --reference $(OUT)/fem.h5 \
	    $(addprefix --prediction ,$(METHOD_PREDICTIONS)) $(addprefix --variant ,$(TABLE_4)) \
	    $(addprefix --beyond-paper ,$(OTHER_ROWS)) --protrusion $(OUT)/protrusion.json $(addprefix --unseen ,$(UNSEEN_TABLES)) \
	    --seconds $(OUT)/seconds.json --output $@
