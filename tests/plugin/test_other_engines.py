"""Engines that run no plugins refuse a model with one of ours by name.

Neither need be installed: what stands in for them has a `put_model` that takes any model.
"""

import importlib
import sys

import mujoco
import pytest

from tendon_mj.plugin import NAME, SERVO
from tendon_mj.plugin.elsewhere import guard_engines
from tests.plugin.rigs import arm
from tests.refusals import refusing

ENGINES = {"mujoco.mjx": "MJX", "mujoco_warp": "MuJoCo Warp"}
ENGINE = "def put_model(m, device=None, **more):\n    return m.nq\n"


@pytest.fixture(params=ENGINES)
def engine(request, tmp_path, monkeypatch):
    """Name of an engine that can be imported, and is not."""
    folder = tmp_path.joinpath(*request.param.split("."))
    folder.mkdir(parents=True)
    (folder / "__init__.py").write_text(ENGINE)
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setattr(mujoco, "__path__", [str(tmp_path / "mujoco"), *mujoco.__path__])
    monkeypatch.delitem(sys.modules, request.param, raising=False)
    yield request.param
    sys.modules.pop(request.param, None)
    if hasattr(mujoco, "mjx"):
        del mujoco.mjx


def refuses(module, name):
    with refusing(NotImplementedError, "tendon_mj.sheath", name, "rollout"):
        module.put_model(arm())
    with refusing(NotImplementedError, name):
        module.put_model(m=arm(), device="cpu")
    assert module.put_model(mujoco.MjModel.from_xml_string("<mujoco/>"), device=None) == 0


def test_imported_after_us(engine):
    refuses(importlib.import_module(engine), ENGINES[engine])


def test_imported_before_us(engine, monkeypatch):
    monkeypatch.setattr(sys, "meta_path", [f for f in sys.meta_path if "tendon" not in repr(f)])
    module = importlib.import_module(engine)
    assert module.put_model(arm()) > 0
    guard_engines((NAME, SERVO))
    refuses(module, ENGINES[engine])


def test_one_that_is_not_installed_is_still_missing(monkeypatch):
    monkeypatch.setattr(mujoco, "__path__", [])
    monkeypatch.setattr(sys, "path", [])
    for name in ENGINES:
        monkeypatch.delitem(sys.modules, name, raising=False)
        with pytest.raises(ModuleNotFoundError, match=name):
            importlib.import_module(name)
