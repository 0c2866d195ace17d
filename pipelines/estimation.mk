# SPDX-License-Identifier: Apache-2.0
# A twin of a captured person in five motions, and the stiffness of its soft tissue estimated from two of them.

# Which of the paper's configurations: CA, CB, CC.
CONFIGURATION ?= CC
ESTIMATION = $(OUT)/estimation
ESTIMATION_MOTIONS = $(wildcard configs/dynamic-motions/*.json)
ESTIMATION_TRAINING = jumping_jacks,running_on_the_spot
# body_0007 is the eighth.
ESTIMATION_PERSON = $(firstword $(AVATAR))
ESTIMATION_BODY = $(shell echo $(ESTIMATION_PERSON) | sed 's/.*_0*\([0-9]\)/\1/')

.PHONY: estimate
estimate: estimation-tools ## a twin's captures, and its soft tissue estimated from them, out/<preset>/estimation/; [AVATAR=body_0000 CONFIGURATION=CA|CB|CC]
	@$(MAKE) --no-print-directory $(ESTIMATION)/$(ESTIMATION_PERSON)-$(CONFIGURATION).json
	@echo "$(ESTIMATION)/$(ESTIMATION_PERSON)-$(CONFIGURATION).{json,png}, $(ESTIMATION)/$(ESTIMATION_PERSON).png"

$(ESTIMATION)/motions.h5: $(OUT)/template.h5 $(ESTIMATION_MOTIONS)
	@mkdir -p $(ESTIMATION)
	$(STAGE) dynamic-motions $(BIN)/import-motion --force --template $< --joint-maps configs/joint-maps \
	    --joint-limits configs/joint-limits.json --motion configs/dynamic-motions --frame-rate 240 --interpolate --output $@

$(ESTIMATION)/$(ESTIMATION_PERSON)-twin.h5: $(OUT)/template.h5 $(OUT)/bodies.h5 $(ESTIMATION)/motions.h5 \
    $(call OPTIONS_OF,simulate-capture)
	$(STAGE) simulate-capture $(BIN)/simulate-capture $(RUN) --template $(OUT)/template.h5 --bodies $(OUT)/bodies.h5 \
	    --body $(ESTIMATION_BODY) --poses $(ESTIMATION)/motions.h5 --output $@

$(ESTIMATION)/$(ESTIMATION_PERSON)-$(CONFIGURATION).json: $(DYNAMICS_AVATAR) $(ESTIMATION)/$(ESTIMATION_PERSON)-twin.h5 \
    $(call OPTIONS_OF,estimate-tissue)
	$(STAGE) measure-motion $(BIN)/measure-motion --force --avatar $(DYNAMICS_AVATAR) --capture $(ESTIMATION)/$(ESTIMATION_PERSON)-twin.h5 \
	    --output $(ESTIMATION)/$(ESTIMATION_PERSON)-motion.json --picture $(ESTIMATION)/$(ESTIMATION_PERSON).png
	$(STAGE) estimate-tissue $(BIN)/estimate-tissue $(RUN) --configuration $(CONFIGURATION) --train $(ESTIMATION_TRAINING) \
	    --avatar $(DYNAMICS_AVATAR) --capture $(ESTIMATION)/$(ESTIMATION_PERSON)-twin.h5 \
	    --output $(ESTIMATION)/$(ESTIMATION_PERSON)-$(CONFIGURATION)-stiffness.json --report $@ \
	    --chart $(ESTIMATION)/$(ESTIMATION_PERSON)-$(CONFIGURATION).png
