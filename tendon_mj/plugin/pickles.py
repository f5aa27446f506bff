"""Models with a sheath or servo in other processes.

A model refers to a plugin by its slot in the table of plugins. MuJoCo does not look whether the
slot is taken, so a process that has not registered the plugins is killed when it loads a pickle of
such a model, as workers of `multiprocessing` are that are spawned. The pickles made here name a
function of this package instead, and loading them imports it.
"""

from __future__ import annotations

import copyreg
import ctypes
from collections.abc import Mapping
from typing import Any

import mujoco

from tendon_mj.errors import EngineError
from tendon_mj.plugin.abi import offset, plugin_at


def plugins_of(model: mujoco.MjModel) -> dict[int, str]:
    """Slot to name of the plugins that a model has instances of."""
    return {int(slot): plugin_at(slot) for slot in set(model.plugin)}


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
