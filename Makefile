# The verbs of this project. `make demo` and `make test` need nothing but Python >= 3.11, make and a C compiler.
PYTHON ?= python3
override VENV := .venv
override BIN := $(VENV)/bin
override PIP := $(BIN)/python -I -m pip
WORKERS ?= auto
CASES ?= 100000
SEED ?= 0
BEFORE ?=
VARIANTS ?= 20000

.DEFAULT_GOAL := help
.PHONY: help install demo quick test test-slow fuzz wheel docs check bench differential instructions embedded-counts generate figures clean
.NOTPARALLEL:  # one pip at a time in .venv

help:  ## show this list
	@awk -F ':.*## ' '/^[a-z-]+:.*## / {printf "  make %-16s %s\n", $$1, $$2}' $(MAKEFILE_LIST)

install: $(VENV)/installed  ## create .venv with mrts and everything that tests and checks need

# A .venv belongs to the folder it was made in: its scripts and its way to the sources hold that path. One that came
# here with a moved or copied folder is made anew; one that make did not make, or a link to one, is not touched.
UNFIT := $(filter anew refuse,$(shell \
  if test -L $(VENV); then echo refuse; elif test -e $(VENV); then \
    case "$$(grep -s '^command = ' $(VENV)/pyvenv.cfg)" in \
    (*" $$(pwd -P)/$(VENV)") test -x $(VENV)/bin/python || echo anew;; \
    (*) test -e $(VENV)/demo -o -e $(VENV)/installed && echo anew || echo refuse;; esac; fi))
.PHONY: $(UNFIT)

refuse:
	@echo "$(VENV) is a link, or was not made by make in this folder: move it away, and make makes its own" >&2; exit 1

anew:
	rm -rf $(VENV)

# Nothing reaches Python that names other code, and of pip's variables only those that say where packages come from.
unexport PYTHONPATH PYTHONHOME PYTHONUSERBASE __PYVENV_LAUNCHER__ MYPYPATH
PACKAGE_SOURCES := INDEX_URL EXTRA_INDEX_URL FIND_LINKS NO_INDEX TRUSTED_HOST CERT CLIENT_CERT PROXY KEYRING_PROVIDER
PACKAGE_SOURCES += CONFIG_FILE CACHE_DIR NO_CACHE_DIR DEFAULT_TIMEOUT TIMEOUT RETRIES USE_FEATURE
unexport $(filter-out $(PACKAGE_SOURCES:%=PIP_%),$(filter PIP_%,$(.VARIABLES)))
# Packages are compiled when they are imported, not all of them at once when they are installed.
unexport PYTHONDONTWRITEBYTECODE

# This folder's mrts with what EXTRAS need, into .venv and nowhere else
define INSTALL
	$(PYTHON) -m venv $(VENV)
	@! $(PIP) config list | grep -E '\.(target|prefix|root|python)=' || \
	  { echo "pip is told to install elsewhere: take that out, or set PIP_CONFIG_FILE=/dev/null" >&2; exit 1; }
	$(PIP) install --quiet --disable-pip-version-check --no-compile --no-user -c constraints.txt -e '.[$(EXTRAS)]'
	touch $@
endef

$(VENV)/demo: EXTRAS := plot
$(VENV)/installed: EXTRAS := plot,test,check
$(VENV)/bench: EXTRAS := bench

$(VENV)/demo $(VENV)/bench: pyproject.toml setup.py constraints.txt $(UNFIT)
	$(INSTALL)

$(VENV)/installed: pyproject.toml setup.py constraints.txt $(UNFIT)
	$(INSTALL)
	touch $(VENV)/demo

demo: $(VENV)/demo  ## generate, compile and run the paper's examples; figures in build/demo
	$(BIN)/mrts demo -o build/demo

quick: install  ## run one test of each kind, in about a minute
	$(BIN)/python -m pytest -q -n $(WORKERS) --dist worksteal -m quick

test: install  ## run the tests, each on small motions and few seeds
	$(BIN)/python -m pytest -q -n $(WORKERS) --dist worksteal -m "not slow"

test-slow: install  ## run the others: many seeds, sanitizers, cross-compilation, browsers, rivals
	$(BIN)/python -m pytest -q -n $(WORKERS) --dist worksteal -m slow

fuzz: install  ## read CASES damaged input files, from SEED on; look between the samples of 50 motions; draw more cells, loads and variants
	FUZZ_CASES=$(CASES) FUZZ_SEED=$(SEED) $(BIN)/python -m pytest -q -x tests/base/test_mutated_inputs.py
	BETWEEN_MOTIONS=50 $(BIN)/python -m pytest -q -x tests/program/test_between_samples.py
	MORE_DRAWS=5 $(BIN)/python -m pytest -q -x tests/program/test_speed_intervals.py tests/scaling/test_uncertain_load.py \
	  tests/studies

wheel: install  ## build the wheel and use it in an empty environment of each Python that is here
	$(BIN)/python .ci/try_wheel.py

docs: install  ## build the documentation as a site in build/site, with a report to look at
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --strict --quiet
	$(BIN)/mrts scale -q mrts/data/dual_ur5/cell.yaml mrts/data/dual_ur5/lift_and_turn.yaml --what-if --report build/site/lift.html

check: install  ## lint, format and types
	rm -rf build/typing && mkdir -p build/typing && ln -s ../../codegen build/typing/mrts_codegen
	@test build/typing/mrts_codegen/__init__.py -ef codegen/__init__.py || { echo "build is not this folder's own" >&2; exit 1; }
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy -p mrts -p mrts_codegen

bench: install $(VENV)/bench  ## measure speed against what a user would otherwise run, and against the revision BEFORE
	$(BIN)/python benchmarks/table.py $(BEFORE)
	$(BIN)/python benchmarks/range/ranges.py
	$(BIN)/python benchmarks/range/against_daqp.py
	$(BIN)/python benchmarks/range/growth.py
	$(BIN)/python benchmarks/range/uncertain_load.py
	$(BIN)/python benchmarks/timing/parts_of_retime.py
	$(BIN)/python benchmarks/timing/one_arm_timing.py
	$(BIN)/python benchmarks/timing/two_arm_timing.py
	$(BIN)/python benchmarks/timing/coarse_grids.py
	$(BIN)/python benchmarks/smooth_timing.py
	$(BIN)/python benchmarks/smooth_growth.py
	$(BIN)/python benchmarks/closed_loop.py
	$(BIN)/python benchmarks/startup/end_to_end.py
	$(BIN)/python benchmarks/startup/generation_cost.py
	$(BIN)/python benchmarks/variants/rates.py
	$(BIN)/python benchmarks/variants/sweep_speed.py $(VARIANTS)

differential: CASES = 1000
differential: install  ## ask CASES random questions, from SEED on, of this state and of the revision BEFORE; exit 1 if answers differ
	$(BIN)/python benchmarks/differential/compare.py $(or $(BEFORE),$(error BEFORE names no revision)) $(CASES) $(SEED)

instructions: install  ## count instructions of a sample and of whole calls (needs gcc and valgrind)
	$(BIN)/python benchmarks/range/instructions.py
	$(BIN)/python benchmarks/timing/whole_call_instructions.py

embedded-counts: install  ## count instructions on a Cortex-M7 (needs qemu-system-arm and an ARM compiler)
	$(BIN)/python benchmarks/embedded/embedded_counts.py

generate: install  ## regenerate the committed C of the shipped cells
	$(BIN)/mrts generate mrts/data/planar_dual_arm/cell.yaml -o generated/planar_dual_arm
	$(BIN)/mrts generate mrts/data/dual_ur5/cell.yaml -o generated/dual_ur5
	$(BIN)/mrts export mrts/data/planar_dual_arm/cell.yaml -o generated/embedded/planar_dual_arm

figures: install  ## draw the film of the README and the gallery's pictures anew
	$(BIN)/mrts view mrts/data/dual_ur5/cell.yaml mrts/data/dual_ur5/lift_and_turn.yaml --video docs/lift.gif \
	  --side-by-side given,fastest,smooth --rates 11.5
	for motion in planar_dual_arm/lift dual_ur5/lift_and_turn squeeze/lift_and_turn three_arms/lift_and_turn \
	  redundant/lift upper_body/lift uncertain_load/lift_and_turn; do cell=$${motion%/*}; \
	  $(BIN)/mrts view -q mrts/data/$$cell/cell.yaml mrts/data/$$motion.yaml --png docs/gallery/$$cell.png || exit 1; done

clean:  ## remove what the other verbs made
	rm -rf $(VENV) build *.egg-info .pytest_cache .mypy_cache .ruff_cache
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
