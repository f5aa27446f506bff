"""A sheath alone on a bench, without MuJoCo: driven at the input, a spring at the output.

The path is a sheath of uniform bend with ``guides`` guides, the end segments half as long as the
others. Its output end sits on a spring k_se: T_out = T_0 + k_se ξ_out. Every sample is one quasi-
static step of the flow solver, so the result depends on the samples but not on time. Effects of a
law that know no time are here too: asymmetry, extra bend, the mount's compliance, and the backlash
of a drive that prescribes displacement.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tendon_mj.compilation import compiled
from tendon_mj.errors import InvalidValueError
from tendon_mj.sheath.flow import settle
from tendon_mj.sheath.law import Law
from tendon_mj.sheath.segments import released
from tendon_mj.sheath.tables import (
    BACK_DYNAMIC,
    BACK_STATIC,
    CONSTANT,
    DYNAMIC,
    FLOW,
    GIVE,
    GUIDE_ROWS,
    LENGTH,
    SEGMENT_ROWS,
    SHARE,
    SLIP,
    STATIC,
    STORED,
    TENSION,
    WAS,
    Table,
)

Array = NDArray[np.float64]

# Effects that hang on time, or on a state that this bench does not keep.
_NOT_HERE = (
    "stribeck_friction",
    "viscous_friction",
    "friction_gradient",
    "friction_drift",
    "stiffening",
    "creep",
    "tendon_mass",
)


class Response(NamedTuple):
    """What the sheath did, a value per sample.

    Attributes:
        input_tension, output_tension: (samples,) [N].
        input_displacement, output_displacement: (samples,) positive towards the input [m].
        friction_work: (samples,) heat since the start [J].
        unsolved: samples whose flow was not solved.
    """

    input_tension: Array
    output_tension: Array
    input_displacement: Array
    output_displacement: Array
    friction_work: Array
    unsolved: int


def _lay(
    law: Law, length: float, bend: float, guides: int, output_stiffness: float
) -> tuple[Table, Table]:
    """Tables of the sheath at rest under its pretension."""
    if not (np.isfinite(length) and length > 0.0):
        raise InvalidValueError(f"length = {length} [m] must be finite and > 0")
    if not np.isfinite(bend):
        raise InvalidValueError(f"bend = {bend} [rad] must be finite")
    if guides < 1:
        raise InvalidValueError(f"guides = {guides} must be ≥ 1")
    if not output_stiffness > 0.0:
        raise InvalidValueError(f"output_stiffness = {output_stiffness} [N/m] must be > 0")
    if not law.pretension > 0.0:
        raise InvalidValueError(f"pretension = {law.pretension:g} [N] must be > 0 on this bench")
    for name in _NOT_HERE:
        if getattr(law, name) != 0.0:
            raise InvalidValueError(
                f"{name} = {getattr(law, name):g}: this bench knows neither time nor {name}; give "
                "it to the plugin's sheath"
            )
    segments, table = np.zeros((SEGMENT_ROWS, guides + 1)), np.zeros((GUIDE_ROWS, guides))
    strain = law.pretension / law.axial_stiffness
    segments[LENGTH] = length / guides
    segments[LENGTH, [0, -1]] /= 2.0
    segments[STORED] = segments[LENGTH] / (1.0 + strain)
    segments[TENSION] = strain
    segments[SHARE] = 1.0
    segments[LENGTH, -1] += law.pretension / output_stiffness  # give back what T_0 takes
    segments[GIVE, -1] = law.axial_stiffness / output_stiffness
    segments[LENGTH, 0] += law.sheath_compliance * law.pretension
    segments[GIVE, 0] = law.sheath_compliance * law.axial_stiffness
    turned = max(0.0, abs(bend) + law.extra_bend)
    there, back = 1.0 + law.direction_asymmetry, 1.0 - law.direction_asymmetry
    table[STATIC] = np.exp(law.mu_s * there * turned / guides)
    table[DYNAMIC] = np.exp(law.friction * there * turned / guides)
    table[BACK_STATIC] = np.exp(law.mu_s * back * turned / guides)
    table[BACK_DYNAMIC] = np.exp(law.friction * back * turned / guides)
    table[CONSTANT] = law.constant_friction / (guides * law.axial_stiffness)
    return segments, table


@compiled
def _commit(segments: Table, guides: Table, drawn: float) -> float:
    """Make the settled flow the state; return the heat over EA [m]."""
    rubbed = 0.0
    segments[STORED, 0] -= drawn
    for i in range(guides.shape[1]):
        flow = guides[FLOW, i]
        segments[STORED, i] += flow
        segments[STORED, i + 1] -= flow
        guides[WAS, i] = guides[SLIP, i] if flow != 0.0 else 0.0
        rubbed += released(segments[TENSION, i], segments[TENSION, i + 1], flow)
    return rubbed


@compiled
def _settle_drawn(segments: Table, guides: Table, drawn: float) -> bool:
    """Settle with ``drawn`` more tendon wound in than is stored, leaving the state as it was."""
    stored = segments[STORED, 0]
    segments[STORED, 0] = stored - drawn
    solved = settle(segments, guides)
    segments[STORED, 0] = stored
    return solved


@compiled
def _follow_displacement(segments: Table, guides: Table, displacement: Array, out: Array) -> int:
    unsolved, before, heat = 0, 0.0, 0.0
    for k in range(displacement.shape[0]):
        drawn = displacement[k] - before
        if not _settle_drawn(segments, guides, drawn):
            unsolved += 1
        heat += _commit(segments, guides, drawn)
        before = displacement[k]
        last = segments.shape[1] - 1
        out[0, k], out[1, k] = segments[TENSION, 0], segments[TENSION, last]
        out[2, k], out[3, k] = displacement[k], heat
    return unsolved


@compiled
def _find_drawn(segments: Table, guides: Table, target: float) -> float:
    """How much has to be wound in for the input's τ to become ``target`` (rises with it)."""
    low, high = 0.0, 0.0
    _settle_drawn(segments, guides, 0.0)
    miss = segments[TENSION, 0] - target
    low_miss = high_miss = miss
    reach = abs(miss) * segments[LENGTH, 0]
    while miss != 0.0 and low_miss * high_miss > 0.0:
        if miss < 0.0:
            low, low_miss, high = high, high_miss, high + reach
            _settle_drawn(segments, guides, high)
            high_miss = segments[TENSION, 0] - target
        else:
            high, high_miss, low = low, low_miss, low - reach
            _settle_drawn(segments, guides, low)
            low_miss = segments[TENSION, 0] - target
        reach *= 2.0
    side = 0
    for _ in range(200):  # regula falsi, Illinois variant: bracketed, superlinear
        drawn = high - high_miss * (high - low) / (high_miss - low_miss) if high > low else high
        _settle_drawn(segments, guides, drawn)
        miss = segments[TENSION, 0] - target
        if abs(miss) <= 1e-14 * target or high - low <= 1e-18:
            break
        if miss < 0.0:
            low, low_miss = drawn, miss
            high_miss *= 0.5 if side < 0 else 1.0
            side = -1
        else:
            high, high_miss = drawn, miss
            low_miss *= 0.5 if side > 0 else 1.0
            side = 1
    return drawn


@compiled
def _follow_tension(segments: Table, guides: Table, tension: Array, out: Array) -> int:
    unsolved, wound, heat = 0, 0.0, 0.0
    for k in range(tension.shape[0]):
        drawn = _find_drawn(segments, guides, tension[k])
        if not _settle_drawn(segments, guides, drawn):
            unsolved += 1
        heat += _commit(segments, guides, drawn)
        wound += drawn
        last = segments.shape[1] - 1
        out[0, k], out[1, k] = segments[TENSION, 0], segments[TENSION, last]
        out[2, k], out[3, k] = wound, heat
    return unsolved


def _response(law: Law, output_stiffness: float, out: Array, unsolved: int) -> Response:
    input_tension, output_tension = law.axial_stiffness * out[0], law.axial_stiffness * out[1]
    given = (output_tension - law.pretension) / output_stiffness
    work = law.axial_stiffness * out[3]
    return Response(input_tension, output_tension, out[2], given, work, unsolved)


def drive_displacement(
    displacement: ArrayLike,
    law: Law,
    *,
    length: float,
    bend: float,
    guides: int = 16,
    output_stiffness: float = np.inf,
) -> Response:
    """Wind the input end through a history of ξ_in.

    Args:
        displacement: (samples,) ξ_in, tendon wound in since the uniform T_0 [m].
        law: of the tendon and its sheath, pretension > 0.
        length: of the sheath [m].
        bend: its total angle [rad].
        guides: that stand for it.
        output_stiffness: k_se of what holds the output end [N/m]; inf: held.

    Raises:
        InvalidValueError: names the argument, its value and range, or an effect that is not here.
    """
    history = _history("displacement", displacement)
    segments, table = _lay(law, length, bend, guides, output_stiffness)
    out = np.empty((4, len(history)))
    unsolved = _follow_displacement(segments, table, _play(history, law.backlash), out)
    out[2] = history
    return _response(law, output_stiffness, out, unsolved)


def drive_tension(
    tension: ArrayLike,
    law: Law,
    *,
    length: float,
    bend: float,
    guides: int = 16,
    output_stiffness: float = np.inf,
) -> Response:
    """Pull the input end through a history of T_in > 0 [N]; else as ``drive_displacement``."""
    if law.backlash > 0.0:
        raise InvalidValueError(
            f"backlash = {law.backlash:g} [m]: a tension says nothing about the drive behind it"
        )
    history = _history("tension", tension)
    if not (history > 0.0).all():
        raise InvalidValueError(f"tension must be > 0 [N] throughout, got {history.min():g}")
    segments, table = _lay(law, length, bend, guides, output_stiffness)
    out = np.empty((4, len(history)))
    unsolved = _follow_tension(segments, table, history / law.axial_stiffness, out)
    return _response(law, output_stiffness, out, unsolved)


def _play(drive: Array, backlash: float) -> Array:
    """What a drum winds whose drive has to cross a gap first."""
    if backlash == 0.0:
        return drive
    drum, wound = np.empty_like(drive), 0.0
    for k, at in enumerate(drive):
        wound = min(max(wound, at - 0.5 * backlash), at + 0.5 * backlash)
        drum[k] = wound
    return drum


def _history(name: str, values: ArrayLike) -> Array:
    history = np.ascontiguousarray(values, float)
    if history.ndim != 1 or not np.isfinite(history).all():
        raise InvalidValueError(f"{name} must be finite and of shape (samples,)")
    return history
