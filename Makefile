# SPDX-License-Identifier: Apache-2.0
# Neural Deformation Gradients: everything from a bare machine to the tables. `make help` lists the targets.

PRESET  ?= demo
DATA    ?=
JOBS    ?= $(shell nproc)
BUILD   ?= build/release
OUT     ?= out/$(PRESET)
BENCH   ?= all
DEVICE  ?=
CONFIG  ?= configs/$(PRESET).json
# How long a thread of OpenMP looks for work before it sleeps. GCC's default of 300 000 turns takes a core from others
# on machines that are shared (docs/performance.md).
export GOMP_SPINCOUNT ?= 10000

# Make splits words at blanks; better a sentence than half a pipeline in a folder of another name.
$(foreach name,CURDIR OUT DATA BUILD CONFIG SCAN UNSEEN_SCAN PREFIX,$(if $(word 2,$($(name))),$(error $(name)='$($(name))': \
  make cannot work with blanks in paths; take a folder without)))

.DELETE_ON_ERROR:
# Kept although only rules of patterns name them. Not .SECONDARY: files that stand for a choice must not count as
# intermediate, or a choice that was never made would leave what depends on it as it is.
.PRECIOUS: out/templates/%.h5
.DEFAULT_GOAL := help
MAKEFLAGS += --no-builtin-rules
SHELL := /bin/bash
.SHELLFLAGS := -eu -o pipefail -c

BIN := $(BUILD)/bin
CMAKE_FLAGS = -G Ninja $(if $(DATA),-DNDG_DATA="$(abspath $(DATA))")

.PHONY: help deps build tools pipeline-tools avatar-tools dynamics-tools estimation-tools test test-export test-campaign build-asan test-asan test-asan-slow demo templates bodies poses dataset train tables bench format format-check tidy clean

help: ## list the targets and variables
	@printf 'Targets:\n'; grep -hE '^[a-z0-9-]+:.*## ' $(MAKEFILE_LIST) | sort | sed -E 's/^([a-z0-9-]+):.*## /  \1\t/' | expand -t 16
	@printf 'Variables:\n  PRESET=demo|desk|paper|smoke  which configs/<preset>.json (results go to out/<preset>/)\n'
	@printf '  DATA=<folder>      folder with makehuman/, bodyparts3d/, motion/; without it: the built-in body and motions\n'
	@printf '  SOURCE=anatomy|procedural  where bodies come from\n  SEX=male|female    of the template body\n  PAIRS=<n>          training samples, instead of as many as the preset says\n  MOTION=<folders>   motions to import\n  SCAN=<file>        of one person, for body and animate\n  DEVICE=cuda        networks are trained and used on a GPU (docs/performance.md)\n  PREFIX=<folder>    where install puts things\n  JOBS=<n>           parallel build jobs\n'

deps: ## install the Debian packages that are missing
	@pipelines/install-packages.sh

build: ## configure and build everything (Release)
	@pipelines/install-packages.sh --quiet
	@cmake -S . -B $(BUILD) $(CMAKE_FLAGS) > /dev/null
	@cmake --build $(BUILD) -j $(JOBS)

# Those that recipes call, and nothing else: a pipeline need not wait for tests and benchmarks.
TOOLS_OF = $(sort $(shell grep -ohE '[(]BIN[)]/[a-z-]+' $(1) | sed 's,.*/,,'))
tools: TOOLS = $(call TOOLS_OF,pipelines/*.mk)
pipeline-tools: TOOLS = $(call TOOLS_OF,pipelines/dataset.mk pipelines/train.mk pipelines/eval.mk pipelines/page.mk)
avatar-tools: TOOLS = $(call TOOLS_OF,pipelines/dataset.mk pipelines/avatar.mk) fit-shape-space fit-correctives
dynamics-tools: TOOLS = $(call TOOLS_OF,pipelines/dataset.mk pipelines/avatar.mk pipelines/dynamics.mk) fit-shape-space fit-correctives
estimation-tools: TOOLS = $(call TOOLS_OF,pipelines/dataset.mk pipelines/avatar.mk pipelines/estimation.mk) fit-shape-space fit-correctives
tools pipeline-tools avatar-tools dynamics-tools estimation-tools:
	@pipelines/install-packages.sh --quiet
	@cmake -S . -B $(BUILD) $(CMAKE_FLAGS) > /dev/null
	@cmake --build $(BUILD) -j $(JOBS) --target $(TOOLS)

# The daemons of the Slurm test need root, as their installation does; elsewhere that test skips with a line.
test: build ## build and run all tests (Release); DATA=<folder> adds those on real bodies and motions
	@test "$$(id -u)" != 0 || pipelines/install-packages.sh --quiet slurm-wlm munge
	ctest --test-dir $(BUILD) -j $(JOBS) --output-on-failure --no-tests=error

# ParaView's Python brings a VTK that reads XDMF, which Debian's python3-vtk9 does not.
test-export: build ## files for other programs, read back by ParaView, Blender, the Khronos validator and numpy (installs them)
	@pipelines/install-packages.sh --quiet paraview python3-paraview blender $$(command -v npm > /dev/null || echo nodejs npm)
	@cd viewer && npm ci --no-audit --no-fund --silent
	ctest --test-dir $(BUILD) --output-on-failure --no-tests=error -R '^export'

# Minutes on two cores that do nothing else, about: damaged inputs 12, kills 15, full disks 6 (docs/reliability.md).
CAMPAIGN = tests/campaign
test-campaign: build ## 10 000 damaged inputs, 100 kills, full disks: what users' files and bad days do (35 min)
	@$(MAKE) --no-print-directory make-tables PRESET=smoke LEAVE_OUT="$(SLOWER_METHODS)" > /dev/null
	/usr/bin/python3 $(CAMPAIGN)/damaged_inputs.py $(BIN) out/smoke configs --keep out/campaign
	/usr/bin/python3 $(CAMPAIGN)/kills.py $(BUILD) out/smoke
	/usr/bin/python3 $(CAMPAIGN)/full_disks.py $(BUILD) . out/smoke

# Cases tagged [slow] (whole bodies built and fitted) take longer there than all others together.
build-asan:
	@pipelines/install-packages.sh --quiet
	@cmake -S . -B build/asan $(CMAKE_FLAGS) -DCMAKE_BUILD_TYPE=Sanitize -DNDG_SANITIZE=ON -DNDG_WITH_TORCH=OFF > /dev/null
	@cmake --build build/asan -j $(JOBS)

test-asan: build-asan ## the tests that need no libtorch, under address and undefined-behaviour sanitizers, but for the slow ones
	ctest --test-dir build/asan -j $(JOBS) --output-on-failure --no-tests=error -LE slow

test-asan-slow: build-asan ## those that test-asan leaves out: an hour and more
	ctest --test-dir build/asan -j $(JOBS) --output-on-failure --no-tests=error -L slow

include pipelines/dataset.mk
include pipelines/bodies.mk
include pipelines/train.mk
include pipelines/eval.mk
include pipelines/unseen.mk
include pipelines/page.mk
include pipelines/avatar.mk
include pipelines/curve.mk
include pipelines/dynamics.mk
include pipelines/estimation.mk
include pipelines/scan.mk
include pipelines/slurm/slurm.mk
include pipelines/release.mk
include pipelines/install.mk

demo: PRESET := demo
demo: ## the whole pipeline at demo size: bodies, poses, FEM, training, Table 1, pictures; needs no data
	$(CHECK_DATA)
	@test -x $(BIN)/export-scene || echo "The tools are compiled first, about 12 min on two cores. Then come"
	@pipelines/plan.sh $(OUT) $(EXPECTED_SECONDS)
	@$(MAKE) --no-print-directory make-tables PRESET=demo DATA="$(DATA)" LEAVE_OUT="$(SLOWER_METHODS)"
	$(if $(DATA),,@$(MAKE) --no-print-directory check-results PRESET=demo)
	$(NAME_RESULTS)

bench: build ## benchmarks: bench/<name>, results in out/bench/<name>.json
	@pipelines/run-benches.sh "$(BIN)" "$(BENCH)" out/bench

format: ## format all sources
	@pipelines/install-packages.sh --quiet clang-format
	@git ls-files '*.h' '*.cpp' | xargs clang-format -i

format-check: ## fail when a source is not formatted
	@pipelines/install-packages.sh --quiet clang-format
	@git ls-files '*.h' '*.cpp' | xargs clang-format --dry-run -Werror

tidy: build ## clang-tidy on the library (names, bug patterns)
	@pipelines/install-packages.sh --quiet clang-tidy
	@git ls-files 'lib/*.cpp' | xargs -P $(JOBS) -n 4 clang-tidy -p $(BUILD) --quiet

clean: ## remove build/ and out/
	rm -rf build out
