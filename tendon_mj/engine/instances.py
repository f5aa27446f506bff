"""Which sheaths a compiled model has, and where in `mjData.plugin_state` each keeps its numbers."""

from __future__ import annotations

from typing import NamedTuple

import mujoco

from tendon_mj.engine.library import C
from tendon_mj.engine.validate import NAME


class Instance(NamedTuple):
    """A sheath of a model."""

    tendon: str
    state: int  # address of its first number in `mjData.plugin_state`


def _config(model: mujoco.MjModel, instance: int, attribute: str) -> str:
    raw = C.mj_getPluginConfig(model._address, instance, attribute.encode())
    return (raw or b"").decode()


def sheaths(model: mujoco.MjModel) -> dict[str, Instance]:
    """Every sheath of a model by name; an unnamed one goes by its tendon's name."""
    found = {}
    for k in range(model.nplugin):
        tendon = _config(model, k, "tendon")
        ours = C.mjp_getPluginAtSlot(int(model.plugin[k])).contents.name == NAME.encode()
        if ours and not _config(model, k, "sensor"):
            name = mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_PLUGIN, k) or tendon
            found[name] = Instance(tendon, int(model.plugin_stateadr[k]))
    return found
