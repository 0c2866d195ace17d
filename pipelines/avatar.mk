# SPDX-License-Identifier: Apache-2.0
# A statistical body of the preset's bodies and correctives, and soft-tissue avatars made of it (Romero et al. 2020).

# Which of the bodies, by name; several are made side by side.
AVATAR ?= body_0000

.PHONY: avatar
avatar: avatar-tools ## a body's soft tissue as tetrahedra, out/<preset>/avatar/<body>.{h5,png}; [AVATAR=body_0000]
	@$(MAKE) --no-print-directory $(AVATAR:%=$(OUT)/avatar/%.h5)
	@echo "avatar: $(AVATAR:%=$(OUT)/avatar/%.h5), pictures beside"

$(OUT)/statistical_body.h5: $(OUT)/template.h5 $(OUT)/bodies.h5 $(OUT)/splits.h5 $(OUT)/shape_space.h5 $(OUT)/correctives.h5 \
    $(call OPTIONS_OF,fit-statistical-body)
	$(STAGE) fit-statistical-body $(BIN)/fit-statistical-body $(RUN) --template $(OUT)/template.h5 --bodies $(OUT)/bodies.h5 \
	    --splits $(OUT)/splits.h5 --shape-space $(OUT)/shape_space.h5 --correctives $(OUT)/correctives.h5 --output $@

$(AVATAR:%=$(OUT)/avatar/%.h5): $(OUT)/avatar/%.h5: $(OUT)/statistical_body.h5 $(call OPTIONS_OF,make-avatar)
	@mkdir -p $(OUT)/avatar
	$(STAGE) make-avatar $(BIN)/make-avatar $(RUN) --body $< --person $* --picture $(OUT)/avatar/$*.png --output $(OUT)/avatar/$*.h5
