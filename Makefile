# The one door to this project: needs make and any Python from 3.11 on, and installs the rest into .venv.
# `make` by itself lists what there is. PYTHON=... names the interpreter, VENV=... another environment.

PYTHON ?=
BLIND ?=
VENV ?= .venv
BIN := $(VENV)/bin
STAMP := $(VENV)/.installed
PYTEST := $(BIN)/python -m pytest

.DEFAULT_GOAL := help
.PHONY: help setup demo test test-slow test-random lint types check check-generated generate bench blind docs wheel-test clean

help: ## list the targets
	@awk -F ':.*## ' '/^[a-z-]+:.*## / { printf "  make %-16s %s\n", $$1, $$2 }' Makefile

setup: $(STAMP) ## make .venv and install symdyn into it, with all that its tests need
	@echo "$(VENV) is ready"

$(STAMP): pyproject.toml scripts/make_venv.sh
	@PYTHON="$(PYTHON)" sh scripts/make_venv.sh "$(VENV)"
	@touch $@

demo: $(STAMP) ## explain a recording by the physics that its model lacks; writes a report to out/demo
	@$(BIN)/symdyn demo

test: $(STAMP) ## run the tests, all but the slow ones
	@$(PYTEST) -n auto --dist worksteal -m "not slow"

test-slow: $(STAMP) ## run the slow tests
	@$(PYTEST) -n auto -m slow

test-random: $(STAMP) ## run the tests on new random examples
	@$(PYTEST) -n auto --hypothesis-profile=random

lint: $(STAMP) ## check the style (ruff)
	@$(BIN)/python -m ruff check .

types: $(STAMP) ## check the types (mypy, strict)
	@$(BIN)/python -m mypy

check: lint types test check-generated ## all that a change must pass

generate: $(STAMP) ## write generated/ anew: kernel, equations and manifest of every bundled machine
	@$(BIN)/symdyn generate --all --out generated

check-generated: $(STAMP) ## see whether generated/ is what the code of today writes, byte by byte
	@$(BIN)/python scripts/check_generated.py generated

bench: $(STAMP) ## time the kernels beside Pinocchio and CasADi (builds both in C++ once, for some minutes)
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[bench]'
	@$(BIN)/python -m benchmarks.speed
	@$(BIN)/python -m benchmarks.frequency
	@$(BIN)/python -m benchmarks.drive

blind: $(STAMP) ## score the diagnosis on plants it cannot see (hours; goes on where it was; BLIND="--first 40" for fewer)
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[blind]'
	@$(BIN)/python -m benchmarks.blind $(BLIND)

docs: $(STAMP) ## write the generated pages of docs/ anew; emps.md needs the recordings that SYMDYN_DATASETS names
	@$(BIN)/python scripts/cost_tables.py generated docs/costs.md
	@$(BIN)/python -m benchmarks.paper
	@$(BIN)/python benchmarks/emps_ladder.py

wheel-test: $(STAMP) ## build the wheel, install it elsewhere, and use it there
	@$(BIN)/python scripts/wheel_test.py

clean: ## remove what was built; .venv and generated/ stay
	@rm -rf build dist out .pytest_cache .mypy_cache .ruff_cache .hypothesis
	@find symdyn tests benchmarks scripts generated -name __pycache__ -type d -prune -exec rm -rf {} + 2>/dev/null || true
