# Everything a fresh clone needs: python3 (3.11 or newer) and make.
PYTHON ?= python3
VENV   ?= .venv
BIN    := $(VENV)/bin
OUT    ?= out/demo
# The stamp of what is installed holds its folder and its Python. An environment that was moved, whose
# Python is gone, or that is of another Python than a given PYTHON, is made again.
INSTALLED := $(VENV)/.installed
STAMP  := $(VENV)/.ready
FOUND  := $(abspath $(VENV)) $(shell $(BIN)/python --version 2>/dev/null)
GIVEN  := $(filter-out file,$(origin PYTHON))
WANTED := $(if $(GIVEN),$(abspath $(VENV)) $(shell $(PYTHON) --version),$(FOUND))
# Python keeps what it compiles as it imports, unless this is set, as in some containers: a command would
# take twice as long to start. pip would compile all there is, for half of the time of an installation.
export PYTHONDONTWRITEBYTECODE :=
PIP_INSTALL := -m pip --quiet --quiet --disable-pip-version-check install --no-compile
# Real measurements are not in the repository (docs/data.md says where they come from).
ifneq ($(wildcard ../shared/data),)
export TENDON_MJ_DATA ?= $(abspath ../shared/data)
endif
# Nor are models of others, on which friction is tried.
ifneq ($(wildcard ../shared/models),)
export TENDON_MJ_MODELS ?= $(abspath ../shared/models)
endif

.PHONY: demo kaneko1991 force_servo cable_tool measured_joint positioning_system studies compiled docs test test-long test-oldest test-newest soak check format test-wheel test-mujocos clean

demo: $(STAMP)                ## the main job: compare, render, replay, diagnose
	$(BIN)/tendon-mj demo --out $(OUT)

kaneko1991 force_servo cable_tool measured_joint positioning_system: $(STAMP)  ## an experiment, into out/ and its name
	$(BIN)/python -m experiments.$@ --out out/$@

# Before a change of the search, the selection or the proof of a diagnosis lands.
studies: $(STAMP)             ## studies of real data beside the figures that their READMEs state
	$(BIN)/python -m experiments.studies

docs: $(STAMP)                ## the site, into out/site; warnings are errors
	$(BIN)/python -m sphinx -q -W --keep-going -c docs . out/site
	@echo "out/site/index.html"

test: $(STAMP)                ## the test suite
	$(BIN)/pytest -n auto --dist worksteal

test-long: $(STAMP)           ## tests that take up to a minute each
	$(BIN)/pytest -n auto --dist worksteal -m long

soak: test-long               ## long trials of what docs/guarantees.md promises: some hours
	TENDON_MJ_EXAMPLES=20000 $(BIN)/pytest -n auto tests/guarantees/test_laws.py tests/guarantees/test_energy.py tests/guarantees/test_extremes.py tests/sheath
	$(BIN)/python -m experiments.soak --out out/soak

check: $(INSTALLED)           ## formatter, linter, strict types, layers, budget of lines
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/lint-imports --no-cache
	$(BIN)/python -m experiments.budget

format: $(STAMP)
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .

ifneq ($(shell cat $(INSTALLED) 2>/dev/null),$(strip $(WANTED)))
.PHONY: $(INSTALLED)
endif

# Made from nothing, so that no earlier environment shows through. The extra brings what dm-control
# requires, but for labmaze, which newer Pythons can't install (pyproject.toml).
$(INSTALLED): pyproject.toml constraints.txt
	$(PYTHON) -m venv --clear $(VENV)
	$(BIN)/python $(PIP_INSTALL) -c constraints.txt -e '.[dev]'
	$(BIN)/python $(PIP_INSTALL) -c constraints.txt --no-deps dm-control
	@echo "$(abspath $(VENV)) $$($(BIN)/python --version)" > $@

$(STAMP): $(INSTALLED)
	$(BIN)/python -m tendon_mj.native
	@touch $@

compiled: $(STAMP)            ## the plugins, for this machine

# The wheel, in an environment of its own and away from the clone: the README without any extra, and
# the demo with the laboratory.
test-wheel: $(STAMP)
	rm -rf dist
	$(BIN)/python -m hatchling build -t wheel
	$(BIN)/python -m venv --clear .venv-wheel
	.venv-wheel/bin/python $(PIP_INSTALL) -c constraints.txt pytest hypothesis dist/*.whl
	.venv-wheel/bin/pytest --import-mode=importlib tests/test_snippets.py -k readme
	.venv-wheel/bin/python $(PIP_INSTALL) -c constraints.txt "$$(echo dist/*.whl)[lab]"
	cd "$$(mktemp -d)" && $(CURDIR)/.venv-wheel/bin/tendon-mj demo

# The plugin with other releases of MuJoCo: `make test-mujoco-3.14`; the oldest, the constraints' and the
# newest by `make test-mujocos`.
test-mujocos: test-mujoco-3.11 test-mujoco-3.17 test-mujoco-4.0

test-mujoco-%:
	$(PYTHON) -m venv --clear .venv-mujoco-$*
	.venv-mujoco-$*/bin/python $(PIP_INSTALL) 'mujoco~=$*.0' 'mujoco-warp~=$*.0' -e '.[lab]' $(TESTED_WITH)
	.venv-mujoco-$*/bin/pytest -n auto --dist worksteal -o filterwarnings=default tests/plugin tests/attach tests/sheath tests/theory tests/warp tests/test_native.py

TESTED_WITH := numba pytest pytest-xdist hypothesis hatchling

# The suite with the oldest and with the newest release of every requirement, as pyproject.toml bounds them.
test-oldest test-newest: test-%: .venv-%/.ready
	.venv-$*/bin/pytest -n auto --dist worksteal -o filterwarnings=default  # packages warn of one another

.venv-oldest/.ready: RELEASES := lowest-direct
.venv-newest/.ready: RELEASES := highest
.venv-oldest/.ready .venv-newest/.ready: pyproject.toml
	$(PYTHON) -m venv --clear $(@D)
	$(@D)/bin/python $(PIP_INSTALL) uv
	VIRTUAL_ENV=$(@D) $(@D)/bin/uv pip install --quiet --resolution $(RELEASES) -e '.[dev]'
	VIRTUAL_ENV=$(@D) $(@D)/bin/uv pip install --quiet --no-deps 'dm-control>=1.0.50,<2'
	touch $@

clean:
	rm -rf .venv .venv-* out dist .mypy_cache .pytest_cache .ruff_cache
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
