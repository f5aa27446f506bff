"""Run a chain of elements with effects on a prescribed input displacement.

Equations: docs/theory.md, section 5.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tendon_mj.errors import InvalidValueError
from tendon_mj.reference.checks import FloatArray, number, vector
from tendon_mj.reference.effect_march import COLUMNS, march_effects
from tendon_mj.reference.effects import MEMORY, Carriage, Effects
from tendon_mj.reference.elements import ElementChain
from tendon_mj.reference.run import step_counts

TIME_STEP = 1.25e-4  # s; figures of its convergence in tests/reference/test_effects.py


@dataclass(frozen=True, eq=False)
class EffectRun:
    """What a run of `simulate_effects` gave; histories have the shape of ``time``.

    Args:
        time: as given [s].
        input_tension: T_in [N].
        output_tension: T_out [N].
        input_displacement: ξ_in as given [m].
        output_displacement: ξ_out of the tendon's output end, toward the input [m].
        input_work: done on the tendon at the drum so far [J], by the trapezoidal rule.
        unsolved_steps: steps whose equations were not solved within the iterations allowed.
    """

    time: FloatArray
    input_tension: FloatArray
    output_tension: FloatArray
    input_displacement: FloatArray
    output_displacement: FloatArray
    input_work: FloatArray
    unsolved_steps: int


def simulate_effects(
    chain: ElementChain,
    effects: Effects,
    time: npt.ArrayLike,
    input_displacement: npt.ArrayLike,
    *,
    carriages: Sequence[Carriage] = (),
    preload: float | None = None,
    time_step: float = TIME_STEP,
) -> EffectRun:
    """Integrate a chain with effects from rest under T_0; see `effects`, `effect_march`.

    Elements are fixed in the sheath and their displacement is the unstretched length that has
    passed; likewise ξ_in is unstretched length wound in. With infinitesimal strain (the default of
    ``effects.axial_stiffness``) that is no difference to `simulate_chain`.

    Args:
        chain: the elements, of the exponential law; its friction_force joins constant_friction.
        effects: on top.
        time: instants of the input [s], rising; friction drifts from 0 on. Shape (samples,), at
            least 2.
        input_displacement: ξ_in [m], linear between instants. A number or of ``time``'s shape.
        carriages: from the tendon's output to the ground, in place of the chain's massless
            environment and sensor springs.
        preload: tension that the carriages' springs balance where they start [N]; None is T_0. If
            it is not, the tendon was mounted too tight or too loose, and settles first.
        time_step: longest step [s], > 0. Order 2, but for μ_s > μ_d.

    Raises:
        InvalidValueError: a history or a chain that does not fit.
    """
    instants = vector("time", time)
    counts = step_counts(instants, number("time_step", time_step, above=0.0))
    history = vector("input_displacement", input_displacement, instants.size)
    if np.isinf(chain.input_stiffness) or chain.law != "exponential":
        raise InvalidValueError(
            f"input_stiffness is {chain.input_stiffness:g} and law is {chain.law!r}; effects need "
            "a finite input_stiffness and the exponential law"
        )
    alpha = 1.0 / effects.axial_stiffness
    elastic = _strained(chain.pretension, effects.stiffening * alpha)
    record = np.zeros((instants.size, COLUMNS))
    n = chain.n
    unsolved = march_effects(
        instants,
        history,
        counts,
        np.concatenate(([chain.input_stiffness], chain.stiffness)),
        np.concatenate([chain.mass + effects.tendon_mass / n, [c.mass for c in carriages]]),
        np.concatenate([chain.damping, np.zeros(len(carriages))]),
        np.array([[c.stiffness for c in carriages], [c.damping for c in carriages]]),
        np.array([effects.sheath_compliance, 1.0 / chain.output_stiffness]),
        np.array(
            [
                chain.pretension,
                alpha,
                effects.stiffening,
                elastic + effects.creep * chain.pretension,
                chain.pretension if preload is None else number("preload", preload),
            ]
        ),
        np.maximum(chain.bend_angle + effects.extra_bend / n, 0.0),
        chain.static_friction,
        chain.dynamic_friction,
        chain.friction_force + effects.constant_friction / n,
        effects.viscous_friction / n,
        float(effects.retardation_time),
        float(effects.direction_asymmetry),
        float(effects.friction_gradient),
        float(effects.friction_drift),
        np.array([effects.stribeck_friction, effects.stribeck_velocity, MEMORY]),
        float(effects.backlash),
        np.array([effects.creep, effects.creep_time]),
        record,
    )
    columns = np.ascontiguousarray(record.T)
    return EffectRun(
        time=instants,
        input_tension=columns[0],
        output_tension=columns[1],
        input_displacement=history,
        output_displacement=columns[3],
        input_work=columns[4],
        unsolved_steps=int(unsolved),
    )


def _strained(tension: float, stiffening: float) -> float:
    """EA ε for which EA ε (1 + κ ε) is ``tension`` [N]; ``stiffening`` is κ/EA [1/N]."""
    return 2.0 * tension / (1.0 + math.sqrt(1.0 + 4.0 * stiffening * tension))
