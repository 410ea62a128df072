# make demo            the main job on the built-in bridge;  DATA=folder  runs it on real recordings
# make test            everything that a change is likely to break, in minutes;   make test-all   all tests
# make lint            formatter, linter and type checker
# make docs            the documentation as a site, in runs/docs/site; warnings are errors
# make licences        the licence of every package that the program needs
#
# The set-up checks every package against its digest in requirements.lock. PyTorch without CUDA, on Linux, is on PyTorch's
# own index, which pip then has to know; that of Python 3.11 is in the lock.  TORCH=pypi  takes PyPI's, for any Python,
# with gigabytes of libraries;  LOCK=  checks nothing, and goes by the versions of constraints.txt alone.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
OUT ?= runs/demo
DATA ?=
TORCH ?= $(if $(filter Linux,$(shell uname -s)),cpu,pypi)
LOCK ?= requirements.lock requirements-torch-$(TORCH).lock
INSTALL := $(BIN)/python -m pip install --quiet --disable-pip-version-check
PROJECTS := --editable '.[dev]' --editable ./benchmarks

.PHONY: demo test test-all lint docs licences setup clean
setup: $(VENV)/.ready

$(VENV)/.ready: pyproject.toml constraints.txt $(LOCK) scripts/check_system.py
	$(PYTHON) scripts/check_system.py
	$(PYTHON) -m venv $(VENV)
ifeq ($(strip $(LOCK)),)
	$(INSTALL) --constraint constraints.txt $(PROJECTS)
else
	$(INSTALL) --require-hashes $(addprefix --requirement ,$(LOCK))
	$(INSTALL) --no-deps --no-build-isolation $(PROJECTS)
endif
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
	$(INSTALL) --constraint constraints.txt --editable '.[docs]'
	touch $@

licences: setup
	$(BIN)/python scripts/licences.py

clean:
	rm -rf $(VENV) runs
