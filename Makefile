# The verbs of this project. `make demo` and `make test` need nothing but Python >= 3.11, make and a C compiler.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
WORKERS ?= auto
CASES ?= 100000
SEED ?= 0

.DEFAULT_GOAL := help
.PHONY: help install demo test fuzz docs check bench instructions embedded-counts generate clean

help:  ## show this list
	@awk -F ':.*## ' '/^[a-z-]+:.*## / {printf "  make %-16s %s\n", $$1, $$2}' $(MAKEFILE_LIST)

install: $(VENV)/installed  ## create .venv with mrts and everything that tests and checks need

$(VENV)/installed: pyproject.toml constraints.txt
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e '.[plot,test,check]'
	mkdir -p build/typing && ln -sfn ../../codegen build/typing/mrts_codegen
	touch $@

demo: install  ## generate, compile and run the paper's examples; figures in build/demo
	$(BIN)/mrts demo -o build/demo

test: install  ## run all tests
	$(BIN)/python -m pytest -q -n $(WORKERS) --dist worksteal

fuzz: install  ## read CASES damaged input files, from SEED on
	FUZZ_CASES=$(CASES) FUZZ_SEED=$(SEED) $(BIN)/python -m pytest -q -x tests/base/test_mutated_inputs.py

docs: install  ## build the documentation as a site in build/site
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --strict --quiet

check: install  ## lint, format and types
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy -p mrts -p mrts_codegen

bench: install  ## measure speed against what a user would otherwise run
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e '.[bench]'
	$(BIN)/python benchmarks/range_speed.py
	$(BIN)/python benchmarks/fast_path.py
	$(BIN)/python benchmarks/one_arm_timing.py
	$(BIN)/python benchmarks/uncertain_load.py
	$(BIN)/python benchmarks/retiming.py
	$(BIN)/python benchmarks/generation_cost.py

instructions: install  ## count instructions of a sample (needs gcc and valgrind)
	$(BIN)/python benchmarks/instructions.py

embedded-counts: install  ## count instructions on a Cortex-M7 (needs qemu-system-arm and an ARM compiler)
	$(BIN)/python benchmarks/embedded_counts.py

generate: install  ## regenerate the committed C of the shipped cells
	$(BIN)/mrts generate mrts/data/planar_dual_arm/cell.yaml -o generated/planar_dual_arm
	$(BIN)/mrts generate mrts/data/dual_ur5/cell.yaml -o generated/dual_ur5
	$(BIN)/mrts export mrts/data/planar_dual_arm/cell.yaml -o generated/embedded/planar_dual_arm

clean:  ## remove what the other verbs made
	rm -rf $(VENV) build *.egg-info .pytest_cache .mypy_cache .ruff_cache
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
