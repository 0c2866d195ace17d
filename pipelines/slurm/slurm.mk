# SPDX-License-Identifier: Apache-2.0
# The dataset and the training on a cluster (docs/cluster.md).

SHARDS    ?= 16
SLOTS     ?=
PARTITION ?=
TIME      ?= 04:00:00
CPUS      ?= 1
MEMORY    ?= 2G
SBATCH_OPTIONS  ?=
TRAIN_PARTITION ?= $(PARTITION)
TRAIN_TIME      ?= 12:00:00
TRAIN_CPUS      ?= 4
# 9.3 GB for the weights of the paper's size, the cache, the libraries and the samples being read (docs/performance.md).
TRAIN_MEMORY_paper = 24G
TRAIN_MEMORY    ?= $(or $(TRAIN_MEMORY_$(PRESET)),8G)
TRAIN_OPTIONS   ?=

.PHONY: slurm slurm-status slurm-dynamics

# The dataset was checked by the job before: it is not to be made anew there, whatever its time stamp.
SLURM_TRAIN = test "$(OUT)/model.h5" -nt "$(OUT)/fem.h5" || rm -f "$(OUT)/model.h5"; make --no-print-directory \
    -o "$(OUT)/fem.h5" "$(OUT)/model.h5" PRESET="$(PRESET)" OUT="$(OUT)" BUILD="$(BUILD)" CONFIG="$(CONFIG)" \
    DATA="$(DATA)" SOURCE="$(SOURCE)" SEX="$(SEX)" MOTION="$(MOTION)" DEVICE="$(DEVICE)"

slurm: build ## FEM samples as a Slurm job array, then training; once more: submits what failed (docs/cluster.md)
	@$(MAKE) --no-print-directory $(OUT)/splits.h5
	@OUT="$(OUT)" BIN="$(BIN)" CONFIG="$(CONFIG)" SHARDS="$(SHARDS)" SLOTS="$(SLOTS)" PARTITION="$(PARTITION)" \
	    TIME="$(TIME)" CPUS="$(CPUS)" MEMORY="$(MEMORY)" SBATCH_OPTIONS="$(SBATCH_OPTIONS)" NEXT='$(SLURM_TRAIN)' \
	    NEXT_PARTITION="$(TRAIN_PARTITION)" NEXT_TIME="$(TRAIN_TIME)" NEXT_CPUS="$(TRAIN_CPUS)" \
	    NEXT_MEMORY="$(TRAIN_MEMORY)" NEXT_OPTIONS="$(TRAIN_OPTIONS)" pipelines/slurm/submit.sh

# DYNAMICS_MOTION may be a folder: one motion a clip.
slurm-dynamics: dynamics-tools ## the motions of DYNAMICS_MOTION with inertia as a Slurm job array; once more: submits what failed; [SCENE=<file> SHARDS=<n>, at most as many as motions]
	@$(MAKE) --no-print-directory $(DYNAMICS_AVATAR) $(DYNAMICS)/motion.h5
	@OUT="$(DYNAMICS)" BIN="$(BIN)" CONFIG="$(CONFIG)" POSES="$(DYNAMICS)/motion.h5" BODY="--avatar $(abspath $(DYNAMICS_AVATAR))" \
	    SCENE="$(SCENE)" RATE="$(DYNAMICS_RATE)" SHARDS="$(SHARDS)" SLOTS="$(SLOTS)" PARTITION="$(PARTITION)" TIME="$(TIME)" \
	    CPUS="$(CPUS)" MEMORY="$(MEMORY)" SBATCH_OPTIONS="$(SBATCH_OPTIONS)" pipelines/slurm/submit-dynamics.sh

slurm-status: ## how far the array is: samples, rate, time left, shards
	@$(BIN)/collect-samples --splits $(OUT)/splits.h5 --output $(OUT)/fem.h5 --status --shard-count $(SHARDS)
