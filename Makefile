# make demo            the main job on the built-in bridge;  DATA=folder  runs it on real recordings
# make test            everything that a change is likely to break, in minutes;   make test-all   all tests
# make lint            formatter, linter and type checker
# make docs            the documentation as a site, in runs/docs/site; warnings are errors
# make licences        the licence of every package that the program needs
#
# The set-up checks every package against its digest. PyTorch without CUDA comes from an index of its own, where pip knows
# it and the lock has the wheel; else from PyPI, on Linux with gigabytes of libraries.  LOCK=  checks nothing, and goes by
# the versions of constraints.txt alone.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
OUT ?= runs/demo
DATA ?=
LOCK ?= requirements.lock
TORCH := requirements-torch-
INSTALL := $(BIN)/python -m pip install --quiet --disable-pip-version-check
CHECKED := $(INSTALL) --require-hashes
PROJECTS := --editable '.[dev]' --editable ./benchmarks
PYTEST := $(BIN)/python -m pytest -n 2 --dist worksteal

.PHONY: demo test test-all lint docs licences setup clean
setup: $(VENV)/.ready

$(VENV)/.ready: pyproject.toml constraints.txt $(LOCK) scripts/check_system.py
	$(PYTHON) scripts/check_system.py
	$(PYTHON) -m venv $(VENV)
ifeq ($(strip $(LOCK)),)
	$(INSTALL) --constraint constraints.txt $(PROJECTS)
else
	$(CHECKED) --no-deps --requirement $(TORCH)cpu.lock || $(CHECKED) --no-deps --requirement $(TORCH)pypi.lock
	$(CHECKED) --requirement $(LOCK)
	$(INSTALL) --no-deps --no-build-isolation $(PROJECTS)
endif
	touch $@

demo: setup
	$(BIN)/python scripts/demo.py --out $(OUT) $(if $(DATA),--data "$(DATA)")

# Tests are compiled once, whatever the shell says of byte code; each of the two processes keeps to its half of the files,
# so that what a file makes for all its tests is made once.
test test-all: export PYTHONDONTWRITEBYTECODE =

test: setup
	$(PYTEST) -m "not slow"

test-all: setup
	$(PYTEST)

lint: setup
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

docs: $(VENV)/.docs
	$(BIN)/python -m scripts.build_docs --out runs/docs

$(VENV)/.docs: $(VENV)/.ready
	$(INSTALL) --constraint constraints.txt --editable '.[docs]'
	touch $@

licences: setup
	$(BIN)/python scripts/licences.py

clean:
	rm -rf $(VENV) runs
