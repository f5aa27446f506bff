"""Models with a sheath or servo in other processes and other engines.

A model refers to a plugin by its slot in the table of plugins. MuJoCo does not look whether the
slot is taken, so a process that has not registered the plugins is killed when it loads a pickle of
such a model, as workers of `multiprocessing` are that are spawned. The pickles made here name a
function of this package instead, and loading them imports it.

MJX and MuJoCo Warp refuse the sensor or actuator of a plugin without saying whose, and ignore a
sheath that has neither. Their `put_model` is wrapped when they are imported, and refuses by name;
it runs as it is for every other model.
"""

from __future__ import annotations

import contextlib
import copyreg
import ctypes
import functools
import sys
from collections.abc import Mapping, Sequence
from importlib.abc import MetaPathFinder
from importlib.machinery import ModuleSpec
from types import ModuleType
from typing import Any

import mujoco

from tendon_mj.errors import EngineError, NoPluginsError
from tendon_mj.plugin.abi.layout import offset
from tendon_mj.plugin.abi.library import C


def plugin_at(slot: int) -> str:
    """Name of the plugin in a slot, empty where there is none."""
    plugin = C.mjp_getPluginAtSlot(slot)
    return bytes(plugin.contents.name).decode() if plugin else ""


def plugins_of(model: mujoco.MjModel) -> dict[int, str]:
    """Slot to name of the plugins that a model has instances of."""
    return {int(slot): plugin_at(int(slot)) for slot in set(model.plugin)}


def register_pickles(names: tuple[str, ...]) -> None:
    """Pickle models and data with a plugin of these names by `load`, all others as before."""

    def reduce(simulated: Any) -> Any:
        model = simulated if isinstance(simulated, mujoco.MjModel) else simulated.model
        plugins = plugins_of(model)
        stock = simulated.__reduce_ex__(2)
        if not set(plugins.values()) & set(names):
            return stock
        return load, (type(simulated), plugins, stock[2])

    for kind in (mujoco.MjModel, mujoco.MjData):
        copyreg.pickle(kind, reduce)


def load(kind: Any, plugins: Mapping[int, str], state: bytes) -> Any:
    """Make an `MjModel` or `MjData` from MuJoCo's own pickle of it and the plugins that it had.

    Raises:
        EngineError: this process has other plugins in the slots.
    """
    for slot, name in plugins.items():
        if plugin_at(slot) != name:
            raise EngineError(
                f"the pickled {kind.__name__} has plugin {name} in slot {slot}, which in this "
                f"process has {plugin_at(slot) or 'none'}: register the same plugins in the same "
                "order, or pickle the model's MJCF"
            )
    loaded = kind.__new__(kind)
    loaded.__setstate__(state)
    if isinstance(loaded, mujoco.MjData):
        # MuJoCo restores the addresses too that the plugins kept in the process of the pickle
        kept = ctypes.c_void_p.from_address(loaded._address + offset("d_plugin_data")).value
        for instance in range(loaded.model.nplugin):
            if plugins[int(loaded.model.plugin[instance])].startswith("tendon_mj."):
                ctypes.c_void_p.from_address((kept or 0) + 8 * instance).value = None
    return loaded


_ENGINES = {"mujoco.mjx": "MJX", "mujoco_warp": "MuJoCo Warp"}


def guard_engines(names: tuple[str, ...]) -> None:
    """Refuse models with plugins of these names in the other engines, now or once imported."""
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
        specs = (f.find_spec(fullname, path, target) for f in sys.meta_path if f is not self)
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
                        "tendon_mj.warp.put_model takes sheaths to MuJoCo Warp, and "
                        "tendon_mj.warp.take_sheaths has another package call it; mujoco.mj_step, "
                        "and mujoco.rollout for many at once, simulate every model"
                    )
        return original(*arguments, **named)

    module.put_model = put_model  # type: ignore[attr-defined]
