# make demo            the main job on the built-in bridge;  DATA=folder  runs it on real recordings
# make test            everything that a change is likely to break, in minutes;   make test-all   all tests
# make lint            formatter, linter and type checker
# make docs            the documentation as a site, in runs/docs/site; warnings are errors
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
OUT ?= runs/demo
DATA ?=

.PHONY: demo test test-all lint docs setup clean
setup: $(VENV)/.ready

$(VENV)/.ready: pyproject.toml constraints.txt scripts/check_system.py
	$(PYTHON) scripts/check_system.py
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt --editable '.[dev]' --editable ./benchmarks
	touch $@

demo: setup
	$(BIN)/python scripts/demo.py --out $(OUT) $(if $(DATA),--data "$(DATA)")

test: setup
	$(BIN)/python -m pytest -n 2 -m "not slow"

test-all: setup
	$(BIN)/python -m pytest -n 2

lint: setup
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

docs: $(VENV)/.docs
	$(BIN)/python -m scripts.build_docs --out runs/docs

$(VENV)/.docs: $(VENV)/.ready
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt --editable '.[docs]'
	touch $@

clean:
	rm -rf $(VENV) runs
