# Two commands for a newcomer: `make run` and `make test`. Both create the environment they need.

PYTHON ?= python3
VENV   := .venv
PY     := $(VENV)/bin/python
ARGS   ?=

SHELL  := /bin/bash

PIP_INSTALL := $(PY) -m pip install --quiet --disable-pip-version-check --use-pep517
# Build tools are pinned, too; the two names are those of older and newer versions of pip.
export PIP_CONSTRAINT       := requirements/build.txt
export PIP_BUILD_CONSTRAINT := requirements/build.txt

LOCK := --universal --python-version 3.10 --upgrade --no-header --no-emit-index-url --no-annotate \
        -c requirements/build.txt

.PHONY: run test check lint types unit browser smoke env dev picture drill overflow lock clean

## run: start the fleet; options in ARGS, as in make run ARGS="enable_debug:=true"
run: $(VENV)/.run
	@exec tools/foreground $(PY) -m launcher system $(ARGS)

# Tests of the machine's shared memory and processes run after the others, by themselves.
define run_tests
	status=0; \
	$(PY) -m pytest -n auto -m "($(1)) and not alone" --junitxml=build/tests.xml $(2) || status=1; \
	$(PY) -m pytest -m "($(1)) and alone" --junitxml=build/alone.xml $(2) || status=1; \
	exit $$status
endef

## test: lint, types, and the tests that show that each part works
test: lint types
	$(call run_tests,unit or basic)

## check: lint, types and every test that needs no browser
check: lint types
	$(call run_tests,unit or basic or thorough,--hypothesis-profile=search)

## unit: the tests without processes
unit: $(VENV)/.dev
	$(PY) -m pytest -n 2 -m unit tests/unit $(ARGS)

lint: $(VENV)/.dev
	$(PY) -m ruff check .
	$(PY) -m ruff format --check .

types: $(VENV)/.dev
	$(PY) -m mypy

## browser: the tests that look at the graph's page in a real Chromium
browser: $(VENV)/.dev
	$(PY) -m pytest -m browser

## smoke: the fleet as a test: a normal run, and a robot that dies and comes back (70 s)
smoke: $(VENV)/.run
	$(PY) -m launcher smoke system $(ARGS)
	$(PY) -m launcher smoke system --expect launch/stall.expect.yaml $(ARGS)

## overflow: measure how many tasks the slow robot loses
overflow: $(VENV)/.run
	@$(PY) -m group_gp1.queue_overflow $(ARGS)

## picture: draw the graph of the running fleet into docs/fleet.svg
picture: $(VENV)/.dev
	@$(PY) -m tools.draw_fleet docs/fleet.svg

## drill: kill and start robot_2 in the console of the real fleet, draw that into docs/drill.svg
drill: $(VENV)/.dev
	@$(PY) -m tools.record_drill docs/drill.svg

env: $(VENV)/.run
dev: $(VENV)/.dev

# The lists of pinned versions decide: a changed list brings the environment up to date.
$(VENV)/.python:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 10))' \
	  || { echo "error: Python 3.10 or newer is needed; name one: make PYTHON=python3.12 ..."; exit 2; }
	@$(PYTHON) -m venv $(VENV) \
	  || { rm -rf $(VENV); echo "hint: on Debian and Ubuntu: sudo apt-get install python3-venv"; exit 2; }
	@touch $@

$(VENV)/.run: $(VENV)/.python requirements/run.txt setup.py pyproject.toml
	$(PIP_INSTALL) -r requirements/run.txt
	$(PIP_INSTALL) --no-deps --editable .
	@touch $@

$(VENV)/.dev: $(VENV)/.run requirements/dev.txt
	$(PIP_INSTALL) -r requirements/dev.txt
	@touch $@

## lock: choose and pin new versions (needs uv)
lock:
	uv pip compile $(LOCK) setup.py -o requirements/run.txt
	uv pip compile $(LOCK) setup.py requirements/dev.in -o requirements/dev.txt

clean:
	rm -rf $(VENV) build install log *.egg-info .pytest_cache .mypy_cache .ruff_cache .hypothesis
