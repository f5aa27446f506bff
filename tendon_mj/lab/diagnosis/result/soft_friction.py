"""Parts of a model that give way where a rig does not, so that no fitted value is right.

A joint's `frictionloss` is a soft constraint. With MuJoCo's own `solimpfriction` a joint at rest
under a load moves on slowly, where a rig sticks. Play between a motor's joint and its drum has a
flank that gives way (`tendon_mj.lab.data_check.play`).
"""

from __future__ import annotations

import copy
from collections.abc import Collection, Mapping

import numpy as np

from tendon_mj.lab.data_check import play_warnings
from tendon_mj.lab.diagnosis.result.diagnosis import Value
from tendon_mj.lab.replay import Adjustable, Schedule, Simulates, Simulator, expand, values_for

_FRICTION, _PLAY = ".frictionloss", ".backlash"
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


def warn_of_soft_flanks(
    simulate: Simulates, values: Mapping[str, float], fitted: Mapping[str, Value]
) -> list[str]:
    """Say of drums whose fitted play is blurred by the model how to make them follow rigidly.

    Args:
        simulate: a simulator other than the package's has no drums.
        values: parameter → value of the model; ``<parameter> @ <recording>`` for one alone.
        fitted: parameter → value and interval.
    """
    plays = {
        name.removesuffix(_PLAY): (play.value, 0.5 * (play.high - play.low))
        for name, play in fitted.items()
        if name.endswith(_PLAY) and play.value > 0.0
    }
    if not plays or not isinstance(simulate, Simulator):
        return []
    said: dict[str, str] = {}
    for recording in simulate.recordings:
        adjustable = Adjustable(copy.copy(simulate.model))
        known = expand(recording.known, simulate.parameters)
        adjustable.set({**values_for(recording.name, values), **known})
        schedule = Schedule(recording, adjustable.model, None)
        for warning in play_warnings(schedule, adjustable, plays, with_servo=True):
            joint = warning.place.removeprefix(f"{recording.name}, ")
            said.setdefault(
                joint, f"{joint[0].upper()}{joint[1:]}: {warning.value}; {warning.way_out}."
            )
    return list(said.values())
