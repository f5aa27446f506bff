"""Joints whose dry friction creeps at rest, as MuJoCo's does unless it is made stiff.

A joint's `frictionloss` is a soft constraint. With MuJoCo's own `solimpfriction` a joint at rest
under a load moves on slowly, where a rig sticks, and no value of the friction mends it.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping

import numpy as np

from tendon_mj.replay.simulator import Simulator
from tendon_mj.replay.simulator_protocol import Simulates

_FRICTION = ".frictionloss"
_SOFT = (0.9, 0.95, 0.001, 0.5, 2.0)  # MuJoCo's default solimpfriction
_STIFF = "0.999 0.9999 0.001 0.5 2"
_STEPS = 2.0  # time steps in the shortest time constant that MuJoCo takes


def warn_of_soft_friction(
    simulate: Simulates, values: Mapping[str, float], considered: Collection[str] = ()
) -> list[str]:
    """Say of joints with soft dry friction how to make it stiff.

    Args:
        simulate: a simulator other than the package's has no such joints.
        values: parameter → value of the model.
        considered: parameters that may be what is missing, besides those with a value.
    """
    if not isinstance(simulate, Simulator):
        return []
    model, said = simulate.model, []
    for name, value in values.items():
        joint = name.removesuffix(_FRICTION)
        if joint == name or not (value > 0.0 or name in considered):
            continue
        if np.allclose(model.dof_solimp[model.joint(joint).dofadr[0]], _SOFT):
            constant = _STEPS * model.opt.timestep
            said.append(
                f"Joint {joint}: MuJoCo's frictionloss creeps at rest with the default"
                f' solimpfriction. Give the joint solreffriction="{constant:g} 1"'
                f' solimpfriction="{_STIFF}" and diagnose again.'
            )
    return said
