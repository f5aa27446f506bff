"""The sheaths of one world, written into a simulation of MuJoCo's."""

from __future__ import annotations

import functools
from typing import Any

import numpy as np

from tendon_mj.warp.allocate import COMMITTED
from tendon_mj.warp.simulated import Simulated
from tendon_mj.warp.support import PARAMETERS, WITHOUT_PORT


def read_back(found: dict[str, Simulated], tendons: Any, world: int, last: float) -> None:
    """Write parameters and committed state of a world, as `allocate` takes them.

    Args:
        found: sheaths of the simulation, each by name, in the order that they have on the device.
        tendons: on the device.
        world: number of it.
        last: when its last step began [s].
    """

    @functools.cache  # an array is copied from the device once
    def column(name: str) -> Any:
        return getattr(tendons, name).numpy()[:, world]

    parameters = {name: getattr(tendons, name).numpy()[world] for name in PARAMETERS}
    segment, guide, arc = 0, 0, 0
    for k, sheath in enumerate(found.values()):
        law = sheath.state["law"]
        for name, values in parameters.items():
            # of those that are as they were, all digits
            if np.float32(law[name]) != values[k] and not _is_default(name, law[name]):
                law[name] = values[k]
        for name in WITHOUT_PORT:
            law[name] = 0.0
        for name in (*COMMITTED, "started"):
            sheath.state[name] = column(name)[k]
        sheath.state["commit_time"], sheath.state["has_trial"] = last, 0.0
        sheath.state["unsolved"] = tendons.unsolved.numpy()[world, k]
        here = slice(segment, segment := segment + len(sheath.segments))
        for field, name in (
            ("stored", "stored"),
            ("previous_tension", "before"),
            ("support_compliance", "give"),
        ):
            sheath.segments[field] = column(name)[here]
        here = slice(guide, guide := guide + len(sheath.guides))
        sheath.guides["previous_slip"] = column("previous_slip")[here]
        here = slice(arc, arc := arc + len(sheath.arcs))
        if len(sheath.arcs):
            sheath.arcs["touches"] = column("touched")[here]
            for end, name in (("1", "near_tangent"), ("2", "far_tangent")):
                for axis, values in zip("xyz", column(name)[here].T, strict=True):
                    sheath.arcs[axis + end] = values


def _is_default(name: str, value: float) -> bool:
    return name == "axial_stiffness" and value == 0.0
