"""Parts of a model that no fitted value mends: too few guides, soft friction, a soft flank of play.

A joint's `frictionloss` is a soft constraint. With MuJoCo's own `solimpfriction`, as a model may
have it, a joint at rest under a load moves on slowly, where a rig sticks. Play between a motor's
joint and its drum has a flank that gives way (`play_warnings` of `tendon_mj.lab.data_check`). A
simulator other than the package's has none of these parts.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import mujoco
import numpy as np

from tendon_mj.attach import numbers, view_sheath
from tendon_mj.lab.data_check import play_warnings
from tendon_mj.lab.diagnosis.data import Problem
from tendon_mj.lab.diagnosis.fitting import rings
from tendon_mj.lab.diagnosis.result import Value
from tendon_mj.lab.parameter_names import expand, values_for
from tendon_mj.lab.recordings import Recording
from tendon_mj.lab.replay import (
    Adjustable,
    Schedule,
    Simulates,
    Simulator,
    has_soft_friction,
    stiff_friction,
)
from tendon_mj.lab.units import column_unit

# Root mean square error of a tension, in ranges of it, over (μφ)^(3/2) at one guide: at most so
# much, measured on `bench` against many guides. At the end where a displacement is prescribed it is
# 0.1 … 0.6, largest where the tendon hardly slides; at the other end less, but for small loops.
_ERROR, _POWER = 0.6, 1.5

_FRICTION, _PLAY, _GAIN = ".frictionloss", ".backlash", ".kp"


class LumpedSheath(NamedTuple):
    """A sheath in few guides."""

    name: str  # of the sheath
    guides: int  # that it has
    error: float  # that lumping it into these leaves at most [noise]
    enough: int  # guides with which no more than the noise would be left


def too_few_guides(
    problem: Problem, values: Mapping[str, float], left: float
) -> list[LumpedSheath]:
    """Sheaths whose lumping may leave more than noise, up to 0.6 (μφ/n)^1.5 of a tension's range.

    Lumping leaves no more than the rms error ``left`` [noise] of the model with these values.
    """
    if not isinstance(problem.simulate, Simulator):
        return []
    tensions = [
        float(np.ptp(problem.recordings[k].columns[column])) / problem.noise[k][column]
        for k, column, _ in problem.signals
        if column_unit(column) == "N"
    ]
    finest = max(tensions, default=0.0)
    most: dict[str, LumpedSheath] = {}
    for name, guides, exponent in _exponents(problem.simulate, values):
        error = min(left, _ERROR * (exponent / guides) ** _POWER * finest)
        if error > 1.0 and (name not in most or error > most[name].error):
            enough = math.ceil(guides * error ** (1.0 / _POWER))
            most[name] = LumpedSheath(name, guides, error, enough)
    return list(most.values())


def _exponents(
    simulator: Simulator, values: Mapping[str, float]
) -> Iterator[tuple[str, int, float]]:
    """Sheath, its guides, and its μφ, at the start of every recording."""
    for recording in simulator.recordings:
        adjustable = _adjusted(simulator, recording, values)
        model, data = adjustable.model, adjustable.data
        mujoco.mj_forward(model, data)
        for name in simulator.sheaths:
            view = view_sheath(model, data, name)
            bend = view.bend_angle
            total = float(bend.sum() + view.extra_bend)
            yield name, max(bend.size, 1), view.friction * total


def _adjusted(
    simulator: Simulator, recording: Recording, values: Mapping[str, float]
) -> Adjustable:
    """The model of a recording with these values and those that the recording states."""
    known = expand(recording.known, simulator.parameters)
    return simulator.adjusted({**values_for(recording.name, values), **known})


def warn_of_guides(sheaths: Sequence[LumpedSheath]) -> list[str]:
    """Warn of the error that lumping may leave, with the number of guides that would do."""
    return [
        f"That {sheath.name!r} has only {sheath.guides} guides may leave up to"
        f" {sheath.error:.2g} times the noise in a replay, where a smooth sheath leaves none;"
        f" {sheath.enough} guides would do."
        for sheath in sheaths
    ]


def warn_of_ringing(near: tuple[float, float]) -> list[str]:
    """Warn of a model that rings, by the `near_differences` of its residuals."""
    if not rings(near):
        return []
    return [
        "The model rings from step to step, so that rounding decides what it does, and its numbers"
        " may be off by more than their intervals: take a shorter timestep, or damp its cables by"
        " axial_damping."
    ]


def warn_of_soft_friction(simulate: Simulates, values: Mapping[str, float]) -> list[str]:
    """Warn of joints whose dry friction is soft in the model, with the options that make it stiff.

    They still have some with these values.
    """
    if not isinstance(simulate, Simulator):
        return []
    solref, solimp = (numbers(option) for option in stiff_friction(simulate.model))
    return [
        f"Joint {joint}: MuJoCo's frictionloss creeps at rest with the default solimpfriction."
        f' Give the joint solreffriction="{solref}" solimpfriction="{solimp}" and diagnose again.'
        for joint in (n.removesuffix(_FRICTION) for n in values if n.endswith(_FRICTION))
        if values[joint + _FRICTION] > 0.0 and has_soft_friction(simulate.model, joint)
    ]


def warn_of_servos(problem: Problem) -> list[str]:
    """Warn of servos that were taken to hold their joints, with what lets them give way."""
    known, prescribed = problem.simulate.parameters, problem.simulate.joints
    stated = set[str]()
    for recording in problem.recordings:
        stated |= expand({**recording.known, **recording.uncertain}, known).keys()
    stiff = [
        name.removesuffix(_GAIN)
        for name, parameter in known.items()
        if name.endswith(_GAIN)
        and name not in stated
        and any(prescribed.get(joint) for joint in parameter.joints)
    ]
    if not stiff:
        return []
    return [
        f"Joints were taken to be where a servo is commanded ({', '.join(stiff)}), as neither their"
        f" places nor its forces were measured: if it may give way, give {stiff[0] + _GAIN!r} a"
        " range in [uncertain]."
    ]


def warn_of_soft_flanks(
    simulate: Simulates, values: Mapping[str, float], fitted: Mapping[str, Value]
) -> list[str]:
    """Warn of drums whose fitted play is blurred by the model, with the remedy."""
    plays = {
        name.removesuffix(_PLAY): (play.value, 0.5 * (play.high - play.low))
        for name, play in fitted.items()
        if name.endswith(_PLAY) and play.value > 0.0
    }
    if not plays or not isinstance(simulate, Simulator):
        return []
    warnings: dict[str, str] = {}
    for recording in simulate.recordings:
        adjustable = _adjusted(simulate, recording, values)
        schedule = Schedule(recording, adjustable.model, None)
        for warning in play_warnings(schedule, adjustable, plays, with_servo=True):
            joint = warning.place.removeprefix(f"{recording.name}, ")
            warnings.setdefault(
                joint, f"{joint[0].upper()}{joint[1:]}: {warning.value}; {warning.way_out}."
            )
    return list(warnings.values())
