"""Refusal of models with a sheath or servo by engines that run no plugins of MuJoCo's.

MJX and MuJoCo Warp refuse the sensor or actuator of a plugin without saying whose, and leave out
one without either in silence. Their `put_model` is wrapped when they are imported, and refuses by
name; it runs as it is for every other model.
"""

from __future__ import annotations

import contextlib
import functools
import sys
from collections.abc import Sequence
from importlib.abc import MetaPathFinder
from importlib.machinery import ModuleSpec
from types import ModuleType
from typing import Any

import mujoco

from tendon_mj.errors import NoPluginsError
from tendon_mj.plugin.pickles import plugins_of

_ENGINES = {"mujoco.mjx": "MJX", "mujoco_warp": "MuJoCo Warp"}


def guard_engines(names: tuple[str, ...]) -> None:
    """Let the other engines refuse models with plugins of these names, also if imported later."""
    for module in _ENGINES:
        if module in sys.modules:
            _guard(sys.modules[module], names)
    sys.meta_path.insert(0, _Finder(names))


class _Finder(MetaPathFinder):
    """Finds the other engines as the other finders do, and wraps what they import."""

    def __init__(self, names: tuple[str, ...]) -> None:
        self._names = names

    def find_spec(
        self, fullname: str, path: Sequence[str] | None = None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        if fullname not in _ENGINES:
            return None
        others = (finder for finder in sys.meta_path if finder is not self)
        specs = (finder.find_spec(fullname, path, target) for finder in others)
        spec = next((spec for spec in specs if spec), None)
        if spec and spec.loader:
            execute = spec.loader.exec_module

            def exec_module(module: ModuleType) -> None:
                execute(module)
                _guard(module, self._names)

            with contextlib.suppress(AttributeError):  # a loader that cannot be changed
                spec.loader.exec_module = exec_module  # type: ignore[method-assign]
        return spec


def _guard(module: ModuleType, names: tuple[str, ...]) -> None:
    original = getattr(module, "put_model", None)
    if original is None:
        return
    engine = _ENGINES[module.__name__]

    @functools.wraps(original)
    def put_model(*arguments: Any, **named: Any) -> Any:
        for model in (*arguments, *named.values()):
            if isinstance(model, mujoco.MjModel):
                for name in sorted(set(plugins_of(model).values()) & set(names)):
                    raise NoPluginsError(
                        f"the model has plugin {name}, and {engine} runs no plugins; "
                        "tendon_mj.warp.put_model takes sheaths to MuJoCo Warp; mujoco.mj_step, "
                        "and mujoco.rollout for many at once, simulate every model"
                    )
        return original(*arguments, **named)

    module.put_model = put_model  # type: ignore[attr-defined]
