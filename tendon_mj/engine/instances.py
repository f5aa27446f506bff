"""Which sheaths a compiled model has, and where in `mjData.plugin_state` each keeps its numbers."""

from __future__ import annotations

from typing import NamedTuple

import mujoco
import numpy as np
from numpy.typing import NDArray

from tendon_mj.engine import state
from tendon_mj.engine.library import C
from tendon_mj.engine.validate import NAME
from tendon_mj.errors import UnknownNameError
from tendon_mj.sheath.tables import TENSION


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


def segment_tensions(
    model: mujoco.MjModel, data: mujoco.MjData, sheath: str
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The path of a sheath's tendon and the tension along it, at the latest evaluation.

    Returns:
        (n+2, 3) points [m], and (n+1,) tensions of the segments between them [N].

    Raises:
        UnknownNameError: no such sheath.
    """
    known = sheaths(model)
    if sheath not in known:
        raise UnknownNameError("sheath", sheath, known)
    _, segments, _, path = state.unpack(data.plugin_state.ctypes.data + 8 * known[sheath].state)
    stiffness = data.plugin_state[known[sheath].state + state.AXIAL_STIFFNESS]
    return path.reshape(-1, 3).copy(), stiffness * segments[TENSION]
