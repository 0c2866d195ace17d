# SPDX-License-Identifier: Apache-2.0
# A page (docs/viewer.md): a body that training has not seen in a motion, by FEM and by the network side by side. And the
# viewer that pages hold, bundled anew.

PAGE_MOTION ?= configs/motions/squat.json
PAGE_RATE   ?= $(if $(filter smoke,$(PRESET)),3,15)
PAGE = $(OUT)/page
PAGE_METHODS = fem ndg

PAGE_CHOICE = $(PAGE)/choice-motion-$(firstword $(shell echo '$(PAGE_MOTION) $(PAGE_RATE)' | md5sum))
$(PAGE_CHOICE):
	@mkdir -p $(PAGE) && rm -f $(PAGE)/choice-motion-* && touch $@

$(PAGE)/motion.h5: $(OUT)/template.h5 $(PAGE_MOTION) $(PAGE_CHOICE)
	$(STAGE) page-motion $(BIN)/import-motion --force --template $< --joint-maps configs/joint-maps \
	    --joint-limits configs/joint-limits.json --motion $(PAGE_MOTION) --frame-rate $(PAGE_RATE) --output $@

# The first body of the test split.
PAGE_SAMPLES = --template $(OUT)/template.h5 --bodies $(OUT)/bodies.h5 --poses $(PAGE)/motion.h5 \
    --body $$(h5dump -y -w 1 -d /splits/test/bodies $(OUT)/splits.h5 | awk '/^ *[0-9]+,?$$/ { print $$1 + 0; exit }')

$(PAGE)/fem.h5: $(OUT)/bodies.h5 $(OUT)/splits.h5 $(PAGE)/motion.h5 $(call OPTIONS_OF,simulate-fem)
	$(STAGE) page-fem $(BIN)/simulate-fem $(RUN) $(PAGE_SAMPLES) --min-converged 0.9 --output $@

$(PAGE)/ndg.h5: $(OUT)/bodies.h5 $(OUT)/splits.h5 $(PAGE)/motion.h5 $(filter-out --%,$(METHOD_FILES_ndg))
	$(STAGE) page-ndg $(BIN)/animate $(RUN) --method ndg $(METHOD_FILES_ndg) $(ON_DEVICE) $(PAGE_SAMPLES) --output $@

$(REPORT)/page.html: $(PAGE_METHODS:%=$(PAGE)/%.h5)
	$(STAGE) page $(BIN)/export-scene $(RUN) --template $(OUT)/template.h5 --bodies $(OUT)/bodies.h5 --poses $(PAGE)/motion.h5 \
	    $(addprefix --deformations ,$^) --frames 0 --page $@

# A short clip of the same for other programs: bones and muscles as nodes of their own, the flesh by morph targets.
CLIP_FRAMES ?= $(if $(filter smoke,$(PRESET)),9,34)
$(REPORT)/motion.glb: $(PAGE)/ndg.h5
	$(STAGE) scene-motion $(BIN)/export-scene $(RUN) --template $(OUT)/template.h5 --bodies $(OUT)/bodies.h5 --poses $(PAGE)/motion.h5 \
	    --deformations $< --sample 0 --frames $(CLIP_FRAMES) --surface parts --mesh $@

# What `make demo` has left, or the same of a smaller body: its network has seen 32 samples.
VIEWED = $(firstword $(wildcard out/demo/report/page.html) out/view/report/page.html)
.PHONY: view
view: pipeline-tools ## a body in motion in the browser: the demo's page where there is one, else a small one in two minutes
	@test $(VIEWED) != out/view/report/page.html || $(MAKE) --no-print-directory PRESET=smoke OUT=out/view PAGE_RATE=15 $(VIEWED)
	@echo "page: $(VIEWED)"
	@test -z "$${DISPLAY:-}$${WAYLAND_DISPLAY:-}" || ! command -v xdg-open > /dev/null || xdg-open $(VIEWED)

.PHONY: page viewer
page: pipeline-tools ## a page of a body in motion by FEM and by the network, out/<preset>/report/{page.html,motion.glb}; [PAGE_MOTION=<file>] [PAGE_RATE=15]
	@$(MAKE) --no-print-directory $(REPORT)/page.html $(REPORT)/motion.glb
	@echo "page: $(REPORT)/page.html; for other programs: $(REPORT)/motion.glb"

viewer: ## bundle viewer/src and three.js into viewer/dist/viewer.js; needs Node.js and npm
	cd viewer && npm ci --no-audit --no-fund && npm run build
