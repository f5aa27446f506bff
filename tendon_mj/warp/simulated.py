"""The sheaths of a simulation of MuJoCo's, as the plugin keeps them."""

from __future__ import annotations

from typing import Any, NamedTuple

import mujoco
import numpy as np

from tendon_mj.plugin import sheath_arrays, sheaths
from tendon_mj.sheath import ARC

Layout = tuple[tuple[str | int, ...], ...]


class Simulated(NamedTuple):
    """State of one sheath; records with the fields that `tendon_mj.sheath.records` has."""

    state: Any  # scalars of the plugin, with its parameters in `law`
    segments: Any  # (n+1,)
    guides: Any  # (n,)
    arcs: Any  # (arcs,)


def simulated_sheaths(model: mujoco.MjModel, data: mujoco.MjData) -> dict[str, Simulated]:
    """Every sheath of a simulation by name."""
    found = {}
    plugin_state = data.plugin_state
    begin = plugin_state.__array_interface__["data"][0]
    for name, instance in sheaths(model).items():
        state, segments, guides, path = sheath_arrays(model, plugin_state, name, instance.state)
        behind = (path.__array_interface__["data"][0] - begin) // 8 + path.size
        count = int(state["arcs"])
        arcs = plugin_state[behind : behind + count * ARC.itemsize // 8].view(ARC)
        found[name] = Simulated(state, segments, guides, arcs)
    return found


def layout_of(found: dict[str, Simulated]) -> Layout:
    """What a kernel finds its way by, of each sheath: data of another model have another."""
    whole = ("tendon", "driven", "reel_actuator", "reel_joint", "output_joint", "input_at_last")
    return tuple(
        (
            name,
            *(int(sheath.state[field]) for field in whole),
            *(len(part) for part in (sheath.segments, sheath.guides, sheath.arcs)),
        )
        for name, sheath in found.items()
    )


def state_field(sheaths_found: dict[str, Simulated], field: str) -> np.ndarray[Any, Any]:
    """A scalar of each sheath."""
    return np.array([float(found.state[field]) for found in sheaths_found.values()])
