# For a newcomer: `make run` and `make test`. Every target creates the environment that it needs.

PYTHON ?= python3
# The ROS 2 from PyPI: jazzy or kilted, each in an environment for itself.
DISTRO ?= jazzy
OF_DISTRO := $(if $(filter-out jazzy,$(DISTRO)),-$(DISTRO))
ifeq ($(wildcard requirements/run$(OF_DISTRO).txt),)
$(error DISTRO=$(DISTRO): PyPI has wheels of jazzy and kilted)
endif
VENV   := .venv$(OF_DISTRO)
PY     := $(VENV)/bin/python
DOCS_ENV := build/docs-env
ARGS   ?=

SHELL  := /bin/bash

# Images of containers set it: each process of a test would compile all that it imports.
unexport PYTHONDONTWRITEBYTECODE

PIP_INSTALL := tools/pip_install $(PY) -m pip install --disable-pip-version-check --use-pep517
# Pins the build tools as well; older and newer versions of pip read different variables.
export PIP_CONSTRAINT       := requirements/build.txt
export PIP_BUILD_CONSTRAINT := requirements/build.txt

LOCK := --universal --python-version 3.10 --upgrade --no-header --no-emit-index-url --no-annotate \
        -c requirements/build.txt
LOCK_RUN := launcher/pyproject.toml --extra bag
LOCK_DEV := $(LOCK_RUN) --extra build requirements/dev.in

.DEFAULT_GOAL := help
.PHONY: help run test thorough check ros lint types unit coverage browser fuzz smoke overflow picture drill \
        picker docs changelog env dev lock clean cost

## help: print this list
help:
	@awk -F': ' '/^## / { printf "make %-10s %s\n", substr($$1, 4), substr($$0, length($$1) + 3) }' Makefile

## run: start the fleet; launch arguments as in make run ARGS="enable_debug:=true"
run: $(VENV)/.run
	@exec tools/foreground $(PY) -m launcher system $(ARGS)

# With WING=bag, only tests that a change of launcher/bag can break; perhaps none of them is `alone`.
ifdef WING
TESTS   := $(shell $(PYTHON) -m tools.wings $(WING))
NO_TEST := || [ $$? = 5 ]
ifneq ($(.SHELLSTATUS),0)
$(error WING=$(WING))
endif
endif

# Tests marked `alone` inspect shared memory and processes of the whole machine: they run last, and
# only their files are collected. They leave a core idle, for the check of types, and for tests that
# start no run and no node.
ALONE = $(shell grep -rl --include='*.py' 'mark\.alone' tests)
BESIDE = $(if $(TESTS),,tests/language/unit)
define run_tests
	@mkdir -p build
	@status=0; \
	$(PY) -m pytest -n auto -m "($(1)) and not alone" --junitxml=build/$@$(OF_DISTRO).xml $(2) \
	  $(addprefix --ignore=,$(BESIDE)) $(TESTS) || status=1; \
	$(PY) -m mypy > build/types.txt 2>&1 & types=$$!; \
	$(if $(BESIDE),$(PY) -m pytest -m "$(1)" --junitxml=build/$@$(OF_DISTRO)-beside.xml $(2) $(BESIDE) \
	  > build/beside.txt 2>&1 & beside=$$!;) \
	$(PY) -m pytest -m "($(1)) and alone" --junitxml=build/$@$(OF_DISTRO)-alone.xml $(2) $(or $(TESTS),$(ALONE)) \
	  $(NO_TEST) || status=1; \
	$(if $(BESIDE),wait $$beside || status=1; cat build/beside.txt;) \
	wait $$types || status=1; \
	cat build/types.txt; \
	$(PY) -m tools.members; \
	exit $$status
endef

## test: lint, types, unit tests, and basic tests of every part (5 minutes); WING=bag, DISTRO=kilted
test: lint
	$(call run_tests,unit or basic)

## thorough: what make test leaves out: long tests, and all examples of hypothesis (18 minutes)
thorough: lint
	$(call run_tests,thorough or hypothesis,--hypothesis-profile=search)

## check: both in one run: every test that needs no browser (26 minutes)
check: lint
	$(call run_tests,unit or basic or thorough,--hypothesis-profile=search)

## ros: basic tests with rclpy, and the fleet's (2 minutes), for make ros DISTRO=kilted
ros: $(VENV)/.dev
	$(PY) -m pytest -n auto -m "basic and not alone" --junitxml=build/$@$(OF_DISTRO).xml \
	  $(wildcard tests/*/ros) tests/packages/unit/test_distribution.py

## unit: unit tests only; options of pytest in ARGS
unit: $(VENV)/.dev
	$(PY) -m pytest -n 2 -m unit $(ARGS)

## coverage: unit tests with coverage, as text and in build/coverage; more tests with ARGS=tests
coverage: $(VENV)/.dev
	$(PY) -m pytest -n 2 --cov=launcher --cov=group_gp1 --cov-report=term:skip-covered \
	  --cov-report=html:build/coverage $(or $(ARGS),-m unit)

## lint: ruff, the format of the code, and for the fleet the rules of ROS 2 (flake8)
lint: $(VENV)/.dev
	$(PY) -m ruff check .
	$(PY) -m ruff format --check .
	$(PY) -m flake8 group_gp1 launch setup.py

## types: mypy
types: $(VENV)/.dev
	$(PY) -m mypy

## browser: tests of the pages in a real Chromium (3 minutes)
browser: $(VENV)/.dev
	$(PY) -m pytest -n 3 -m browser

## fuzz: 3000 damaged bags through all verbs of bag (5 minutes); ARGS="--first 3000" for others
fuzz: $(VENV)/.dev
	$(PY) -m tests.fuzz.bags $(ARGS)

## smoke: test the running fleet: a normal run, and a robot that is killed and restarted (70 s)
smoke: $(VENV)/.run
	$(PY) -m launcher smoke system $(ARGS)
	$(PY) -m launcher smoke system --expect launch/stall.expect.yaml $(ARGS)

## overflow: measure how many tasks the slow robot loses (4 minutes)
overflow: $(VENV)/.run
	@$(PY) -m group_gp1.queue_overflow $(ARGS)

## picture: draw the graph of the running fleet into docs/assets/fleet.svg
picture: $(VENV)/.dev
	@$(PY) -m tools.draw_fleet docs/assets/fleet.svg

## drill: kill and start robot_2 in the console, draw the terminal into docs/assets/drill.svg, drill-80.svg
drill: $(VENV)/.dev
	@$(PY) -m tools.record_console docs/assets drill drill-80

## picker: use the console's picker, draw the terminal into docs/assets/picker.svg, picker-log.svg
picker: $(VENV)/.dev
	@$(PY) -m tools.record_console docs/assets picker picker-log

## docs: build the documentation as a site into build/site, with links and anchors checked
docs: $(DOCS_ENV)/.installed
	@NO_MKDOCS_2_WARNING=1 $(DOCS_ENV)/bin/mkdocs build --strict --quiet
	@echo "python3 -m http.server --bind 127.0.0.1 --directory build/site 8000"

## changelog: move what is in changes/ into CHANGELOG.md; make changelog VERSION=0.2.0
changelog: $(DOCS_ENV)/.installed
	$(DOCS_ENV)/bin/towncrier build --yes --version $(VERSION)

$(DOCS_ENV)/.installed: requirements/docs.txt
	@mkdir -p build && $(PYTHON) -m venv $(DOCS_ENV)
	@$(DOCS_ENV)/bin/python -m pip install --quiet --disable-pip-version-check -r requirements/docs.txt
	@touch $@

## env: create or update .venv for running the launcher
env: $(VENV)/.run
## dev: create or update .venv with the tools of lint, types and tests
dev: $(VENV)/.dev

# Said before the environment is made, with what comes behind that.
RUN_COST  := 76 MB to download, 320 MB of disk, about half a minute
DEV_COST  := 280 MB to download, 1 GB of disk, 1 to 2 minutes
THEN_run  := Then the fleet starts; Ctrl-C stops it.
THEN_test := Then the tools of the tests ($(DEV_COST)) and the tests (5 minutes).
cost:
	@[ -e $(VENV)/.run ] || printf '%s\n' "Making $(VENV), with ROS 2 from PyPI: $(RUN_COST)." \
	  $(foreach goal,$(MAKECMDGOALS),$(if $(THEN_$(goal)),"$(THEN_$(goal))"))

# The environment is updated whenever one of the lists of pinned versions changes.
$(VENV)/.python: | cost
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 10))' \
	  || { echo "error: Python 3.10 or newer is needed; name one: make PYTHON=python3.12 ..."; exit 2; }
	@$(PYTHON) -m venv $(VENV) \
	  || { rm -rf $(VENV); echo "hint: on Debian and Ubuntu: sudo apt-get install python3-venv"; exit 2; }
	@touch $@

$(VENV)/.run: $(VENV)/.python requirements/run$(OF_DISTRO).txt launcher/pyproject.toml launcher/setup.py setup.py \
               launcher/cli/script/launcher tools/quick_finders.py
	@$(PIP_INSTALL) -r requirements/run$(OF_DISTRO).txt
	@$(PIP_INSTALL) --no-deps --editable .
	@$(PIP_INSTALL) --no-deps --editable ./launcher
	@$(PY) -m tools.quick_finders
	@touch $@

$(VENV)/.dev: $(VENV)/.run requirements/dev$(OF_DISTRO).txt
	@[ -e $@ ] || echo "Adding the tools of lint, types and tests to $(VENV): $(DEV_COST)."
	@$(PIP_INSTALL) -r requirements/dev$(OF_DISTRO).txt
	@touch $@

## lock: upgrade and pin all versions in requirements/ (needs uv)
lock:
	uv pip compile $(LOCK) $(LOCK_RUN) --extra jazzy -o requirements/run.txt
	uv pip compile $(LOCK) $(LOCK_DEV) --extra jazzy -o requirements/dev.txt
	@mkdir -p build && grep -v '^ros-' requirements/dev.txt > build/others.txt
	uv pip compile $(LOCK) $(LOCK_RUN) --extra kilted -c build/others.txt -o requirements/run-kilted.txt
	uv pip compile $(LOCK) $(LOCK_DEV) --extra kilted -c build/others.txt -o requirements/dev-kilted.txt
	uv pip compile $(LOCK) requirements/docs.in -o requirements/docs.txt
	uv pip compile $(LOCK) requirements/export.in -o requirements/export.txt

## clean: remove .venv, .venv-kilted and everything that was built
clean:
	rm -rf .venv .venv-* build install log *.egg-info launcher/*.egg-info .pytest_cache .mypy_cache .ruff_cache .hypothesis .coverage
