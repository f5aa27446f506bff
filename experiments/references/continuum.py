"""The massless tendon on a fine grid: play in log-tension at every point of the sheath.

A tendon without mass under Coulomb friction slides where the profile T_in e^{∓μθ(x)} overtakes the
old one and holds its tension elsewhere, θ(x) the bend angle from the input to x:

    T(x, t) = clip(T(x, t⁻), T_in e^{−μθ(x)}, T_in e^{+μθ(x)})                  eq. (5), any history
    ξ_in = ξ_out + ∫_0^L (T − T_0)/EA dx,   T_out − T_0 = k_se ξ_out            eqs. (6), (15)

eqs. (5), (6), (15) of the paper, here for any curvature and any history. The integral is the
trapezoid's: T has a kink at each front, where Simpson's rule is of order 2 as well. The inner loop
is compiled by Numba: play at every grid point, Newton on the displacement.

Equations: docs/theory.md, section 2.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numba
import numpy as np
import numpy.typing as npt

from experiments.references.checks import drive, series, vector
from tendon_mj.typing import FloatArray


@numba.njit(cache=True)
def displacement(
    tension: float,
    pretension: float,
    decay: FloatArray,
    compliance: FloatArray,
    profile: FloatArray,
) -> tuple[float, float]:
    """Return ξ_in that ``tension`` at the input brings about, and dξ_in/dT_in."""
    total, slope = 0.0, 0.0
    for j in range(profile.size):
        low, high = tension * decay[j], tension / decay[j]
        if profile[j] < low or (j == 0):
            total += compliance[j] * (low - pretension)
            slope += compliance[j] * decay[j]
        elif profile[j] > high:
            total += compliance[j] * (high - pretension)
            slope += compliance[j] / decay[j]
        else:
            total += compliance[j] * (profile[j] - pretension)
    return total, slope


@numba.njit(cache=True)
def tension_for(
    wanted: float,
    pretension: float,
    decay: FloatArray,
    compliance: FloatArray,
    profile: FloatArray,
) -> float:
    """Return T_in ≥ 0 for which ξ_in is ``wanted``.

    Away from the last T_in the function is piecewise linear and convex in the change, rising, so
    that Newton's steps from the last T_in overshoot at most once and then meet the root from one
    side, in at most as many steps as there are fronts.
    """
    slack, _slope = displacement(0.0, pretension, decay, compliance, profile)
    if wanted <= slack:
        return 0.0
    tension = float(profile[0])
    for _ in range(4 * profile.size):
        reached, slope = displacement(tension, pretension, decay, compliance, profile)
        change = max(-tension, (wanted - reached) / slope)
        tension += change
        if abs(change) <= 1e-13 * tension:
            break
    return tension


@numba.njit(cache=True)
def march_play(
    history: FloatArray,
    tension_driven: bool,
    pretension: float,
    decay: FloatArray,
    compliance: FloatArray,
    profile: FloatArray,
    record: FloatArray,
) -> None:
    """Take ``profile`` through ``history``; rows of ``record``: T_in, T_out, ξ_in."""
    for sample in range(history.size):
        tension = history[sample]
        if not tension_driven:
            tension = tension_for(tension, pretension, decay, compliance, profile)
        for j in range(profile.size):
            profile[j] = min(max(profile[j], tension * decay[j]), tension / decay[j])
        record[0, sample] = tension
        record[1, sample] = profile[profile.size - 1]
        reached = 0.0
        for j in range(profile.size):
            reached += compliance[j] * (profile[j] - pretension)
        record[2, sample] = reached if tension_driven else history[sample]


@dataclass(frozen=True, eq=False, kw_only=True)
class Continuum:
    """A sheath of any curvature with a massless elastic tendon; section 2.1 of the paper.

    Args:
        position: x, rising from 0 at the input to L [m]. Shape (points,), at least 2.
        bend_angle: θ(x), angle turned from the input to x, from 0 and never falling [rad].
            Shape (points,).
        axial_stiffness: EA, force per unit strain [N], > 0.
        friction: μ = μ_s = μ_d [–], ≥ 0.
        pretension: T_0 [N], > 0.
        environment_stiffness: k_e [N/m]; inf is a fixed output end.
        sensor_stiffness: k_s [N/m].
    """

    position: FloatArray
    bend_angle: FloatArray
    axial_stiffness: float
    friction: float
    pretension: float
    environment_stiffness: float = np.inf
    sensor_stiffness: float = np.inf

    @property
    def output_stiffness(self) -> float:
        """k_se of environment and sensor in series [N/m]; eq. (15)."""
        return series(self.environment_stiffness, self.sensor_stiffness)


@dataclass(frozen=True, eq=False)
class ContinuumRun:
    """Result of `simulate_continuum`; histories have the shape of the input.

    Args:
        input_tension: T_in [N].
        output_tension: T_out [N].
        input_displacement: ξ_in [m].
        output_displacement: ξ_out = (T_out − T_0)/k_se [m].
        tension: T(x) at the end [N]. Shape (points,).
    """

    input_tension: FloatArray
    output_tension: FloatArray
    input_displacement: FloatArray
    output_displacement: FloatArray
    tension: FloatArray


def continuum(
    bend_angle: float | npt.ArrayLike | Callable[[FloatArray], npt.ArrayLike],
    *,
    length: float,
    axial_stiffness: float,
    friction: float,
    pretension: float,
    environment_stiffness: float = np.inf,
    sensor_stiffness: float = np.inf,
    intervals: int = 256,
) -> Continuum:
    """Lay an even grid over a sheath whose bend is given by its total, an array or a function.

    Args:
        bend_angle: total L/R of a uniform bend [rad]; or θ on ``intervals + 1`` even points; or
            θ(x) as a function of an array of x [m] with θ(0) = 0.
        length: L [m], > 0.
        axial_stiffness, friction, pretension, environment_stiffness, sensor_stiffness: see
            `Continuum`.
        intervals: grid intervals; the error falls as 1/intervals².
    """
    points = intervals + 1
    position = np.linspace(0.0, length, points)
    if callable(bend_angle):
        turned = vector(bend_angle(position), points)
    elif np.ndim(bend_angle) == 0:
        turned = vector(bend_angle, 1)[0] * position / length
    else:
        turned = vector(bend_angle)
    return Continuum(
        position=position,
        bend_angle=turned,
        axial_stiffness=axial_stiffness,
        friction=friction,
        pretension=pretension,
        environment_stiffness=environment_stiffness,
        sensor_stiffness=sensor_stiffness,
    )


def simulate_continuum(
    model: Continuum,
    *,
    input_tension: npt.ArrayLike | None = None,
    input_displacement: npt.ArrayLike | None = None,
    tension: npt.ArrayLike | None = None,
) -> ContinuumRun:
    """Drive the continuum through a history; eqs. (5), (6), (15) of the paper at every instant.

    The result depends on the sequence of input values and not on time. Exact for the grid: T_in
    for a given ξ_in is found by Newton steps on a piecewise linear function, to rounding.

    Args:
        model: the sheath.
        input_tension: T_in [N], ≥ 0, monotone between samples. Shape (samples,).
        input_displacement: ξ_in [m]; exactly one of the two. If it leaves the tendon slack,
            T_in = 0.
        tension: T(x) to start from [N], ≥ 0, shape (points,); None is T_0 throughout.

    Raises:
        InvalidValueError: no input or two.
    """
    history, tension_driven = drive(input_tension, input_displacement)
    start = model.pretension if tension is None else tension
    profile = vector(start, model.position.size)
    cells = np.diff(model.position) / model.axial_stiffness
    compliance = 0.5 * (np.append(cells, 0.0) + np.append(0.0, cells))
    compliance[-1] += 1.0 / model.output_stiffness
    record = np.zeros((3, history.size))
    march_play(
        history,
        tension_driven,
        float(model.pretension),
        np.exp(-model.friction * model.bend_angle),
        compliance,
        profile,
        record,
    )
    return ContinuumRun(
        input_tension=record[0],
        output_tension=record[1],
        input_displacement=record[2],
        output_displacement=(record[1] - model.pretension) / model.output_stiffness,
        tension=profile,
    )
