# Everything a fresh clone needs: python3 (3.11 or newer) and make.
PYTHON ?= python3
VENV   ?= .venv
BIN    := $(VENV)/bin
OUT    ?= out/demo
# Real measurements are not in the repository (docs/data.md says where they come from).
ifneq ($(wildcard ../shared/data),)
export TENDON_MJ_DATA ?= $(abspath ../shared/data)
endif

.PHONY: demo kaneko1991 force_servo test check format test-mujoco4 clean

demo: $(VENV)/.ready          ## the main job: compare, render, replay
	$(BIN)/tendon-mj demo --out $(OUT)

kaneko1991 force_servo: $(VENV)/.ready  ## an experiment, into out/kaneko1991 or out/force_servo
	$(BIN)/python -m experiments.$@ --out out/$@

test: $(VENV)/.ready          ## the whole test suite
	$(BIN)/pytest -n auto

check: $(VENV)/.ready         ## formatter, linter, strict types, import floors
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/pytest -q tests/test_layers.py

format: $(VENV)/.ready
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .

$(VENV)/.ready: pyproject.toml constraints.txt
	$(PYTHON) -m venv $(VENV)
	$(BIN)/pip install --quiet --disable-pip-version-check -c constraints.txt -e '.[dev]'
	touch $@

# In three wheels since 4.0; what they replace has to go first.
MUJOCO4 := mujoco==4.0.0 mujoco-core==4.0.0 mujoco-studio==4.0.0

# The next major MuJoCo, beside the pinned one: plugin and theory.
test-mujoco4: .venv4/.ready
	.venv4/bin/pytest -n auto tests/theory tests/sheath tests/engine

.venv4/.ready: pyproject.toml constraints.txt
	$(PYTHON) -m venv --clear .venv4
	.venv4/bin/pip install --quiet --disable-pip-version-check -c constraints.txt -e '.[dev]'
	.venv4/bin/pip uninstall --quiet --yes mujoco
	.venv4/bin/pip install --quiet --disable-pip-version-check --no-deps $(MUJOCO4)
	touch $@

clean:
	rm -rf .venv .venv4 out dist .mypy_cache .pytest_cache .ruff_cache
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
