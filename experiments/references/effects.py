"""Effects of a transmission beyond Coulomb friction and Hooke's law: one number each.

Every number is 0 by default, and the effect absent. Friction of element i of n, sliding with
speed |v_i| toward the input (dir = +1) or the output (−1), with T_high on the side it moves to:

    T_high = T_low e^{μ_i φ_i} + F_c/n + (c_v/n) |v_i|,
    μ_i = μ max(0, 1 + γ u_i) max(0, 1 + β t) (1 + α dir) + Δμ e^{−w_i/v_s},
    0.02 s · dw_i/dt = |v_i| − w_i,

u_i the tendon that has passed the element; at rest the same with μ_s for μ and no c_v. Tendon:

    T = EA ε (1 + κ ε),   strain = ε + ε_c,   τ_c dε_c/dt = χ T/EA − ε_c.

Equations: docs/theory.md, section 5.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from experiments.references.checks import History, step_counts, vector
from experiments.references.effect_integrator import (
    CARRIAGE,
    COLUMNS,
    ELEMENT,
    NODE,
    SPRING,
    EffectChain,
    Friction,
    Material,
    march_effects,
)
from experiments.references.elements import ElementChain
from tendon_mj.typing import FloatArray

MEMORY = 0.02  # of the sliding speed that velocity weakening sees [s]


@dataclass(frozen=True, kw_only=True)
class Effects:
    """Effects on a chain of elements; the defaults are inert.

    Args:
        stribeck_friction: Δμ, friction at rest above that of fast sliding [–], ≥ 0.
        stribeck_velocity: v_s, speed over which it fades [m/s]; > 0 if Δμ > 0.
        viscous_friction: c_v, of the whole tendon [N s/m], ≥ 0.
        constant_friction: F_c, of the whole tendon besides the chain's own [N], ≥ 0.
        direction_asymmetry: α, −1 < α < 1 [–].
        friction_gradient: γ, share by which μ grows per metre of tendon passed [1/m].
        friction_drift: β, share by which μ grows per second from time 0 on [1/s].
        backlash: b, width of the play between drive and drum; starts centred [m], ≥ 0.
        stiffening: κ, share by which EA grows per unit strain [–], ≥ 0.
        creep: χ, delayed strain over elastic strain [–], ≥ 0.
        creep_time: τ_c [s]; > 0 if χ > 0.
        sheath_compliance: C_s, compliance of the sheath's mount at the input [m/N], ≥ 0.
        tendon_mass: m, of the whole tendon besides the chain's own [kg], ≥ 0.
        extra_bend: φ_x, bend of the whole sheath besides the chain's own [rad].
        retardation_time: τ_r of T = EA (ε + τ_r dε/dt) between elements [s], ≥ 0: the loss in the
            tendon that ends its own ringing if it has mass.
        axial_stiffness: EA [N], > 0: strain per tension, for finite strain and for
            stiffening. inf: strain is infinitesimal, nothing stiffens.
    """

    stribeck_friction: float = 0.0
    stribeck_velocity: float = 0.0
    viscous_friction: float = 0.0
    constant_friction: float = 0.0
    direction_asymmetry: float = 0.0
    friction_gradient: float = 0.0
    friction_drift: float = 0.0
    backlash: float = 0.0
    stiffening: float = 0.0
    creep: float = 0.0
    creep_time: float = 0.0
    sheath_compliance: float = 0.0
    tendon_mass: float = 0.0
    extra_bend: float = 0.0
    retardation_time: float = 0.0
    axial_stiffness: float = math.inf


@dataclass(frozen=True, kw_only=True)
class Carriage:
    """A mass behind the tendon's output, on a spring and a damper to the next one or the ground.

    Args:
        mass: [kg], ≥ 0.
        stiffness: of the spring behind it [N/m], > 0; it is unstrained under T_0.
        damping: of the damper beside that spring [N s/m], ≥ 0.
    """

    mass: float
    stiffness: float
    damping: float


TIME_STEP = 1.25e-4  # s; figures of its convergence in tests/experiments/references/test_effects.py


@dataclass(frozen=True, eq=False)
class EffectRun:
    """Result of `simulate_effects`; histories have the shape of ``time``.

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
    """Integrate a chain with effects from rest under T_0; see `effect_integrator`.

    Elements are fixed in the sheath and their displacement is the unstretched length that has
    passed; ξ_in is wound in under T_0. With infinitesimal strain (the default of
    ``effects.axial_stiffness``) that is no difference to `simulate_chain`.

    Args:
        chain: the elements, of the exponential law, with a finite input_stiffness; its
            friction_force joins constant_friction.
        effects: on top.
        time: instants of the input [s], rising; friction drifts from 0 on. Shape (samples,), at
            least 2.
        input_displacement: ξ_in [m], linear between instants. A number or of ``time``'s shape.
        carriages: from the tendon's output to the ground, in place of the chain's massless
            environment and sensor springs.
        preload: tension that the carriages' springs balance where they start [N]; None is T_0. If
            it is not, the tendon was mounted too tight or too loose, and settles first.
        time_step: longest step [s], > 0. Order 2, but for μ_s > μ_d.
    """
    instants = vector(time)
    driven = vector(input_displacement, instants.size)
    history = History(instants, driven, step_counts(instants, time_step))
    balanced = chain.pretension if preload is None else preload
    record = np.zeros((instants.size, COLUMNS))
    unsolved = march_effects(
        _chain_at_rest(chain, effects, carriages, float(balanced)), history, record
    )
    columns = np.ascontiguousarray(record.T)
    return EffectRun(
        time=instants,
        input_tension=columns[0],
        output_tension=columns[1],
        input_displacement=history.value,
        output_displacement=columns[3],
        input_work=columns[4],
        unsolved_steps=int(unsolved),
    )


def _chain_at_rest(
    chain: ElementChain, effects: Effects, carriages: Sequence[Carriage], preload: float
) -> EffectChain:
    """Chain, effects and carriages at rest under T_0, as the compiled functions take them."""
    n = chain.n
    nodes = np.zeros(n + len(carriages), dtype=NODE)
    nodes["mass"][:n] = chain.mass + effects.tendon_mass / n
    nodes["mass"][n:] = [c.mass for c in carriages]
    nodes["damping"][:n] = chain.damping
    elements = np.zeros(n, dtype=ELEMENT)
    elements["angle"] = np.maximum(chain.bend_angle + effects.extra_bend / n, 0.0)
    elements["static"] = chain.static_friction
    elements["dynamic"] = chain.dynamic_friction
    elements["constant"] = chain.friction_force + effects.constant_friction / n
    springs = np.zeros(n + 1, dtype=SPRING)
    springs["stiffness"] = np.concatenate(([chain.input_stiffness], chain.stiffness))
    springs["tension"] = springs["previous_tension"] = chain.pretension
    springs["creep_strain"] = springs["next_creep_strain"] = effects.creep * chain.pretension
    behind = np.zeros(len(carriages), dtype=CARRIAGE)
    behind["stiffness"] = [c.stiffness for c in carriages]
    behind["damping"] = [c.damping for c in carriages]
    return EffectChain(
        material=_material(chain, effects),
        friction=_friction(chain, effects),
        preload=preload,
        mount_compliance=float(effects.sheath_compliance),
        output_compliance=float(1.0 / chain.output_stiffness),
        backlash=float(effects.backlash),
        nodes=nodes,
        elements=elements,
        springs=springs,
        carriages=behind,
    )


def _material(chain: ElementChain, effects: Effects) -> Material:
    compliance = 1.0 / effects.axial_stiffness
    elastic = _elastic_strain(chain.pretension, effects.stiffening * compliance)
    return Material(
        pretension=float(chain.pretension),
        compliance=float(compliance),
        initial_strain=float(elastic + effects.creep * chain.pretension),
        stiffening=float(effects.stiffening),
        creep=float(effects.creep),
        creep_time=float(effects.creep_time),
        retardation_time=float(effects.retardation_time),
    )


def _friction(chain: ElementChain, effects: Effects) -> Friction:
    return Friction(
        viscous=float(effects.viscous_friction / chain.n),
        asymmetry=float(effects.direction_asymmetry),
        gradient=float(effects.friction_gradient),
        drift=float(effects.friction_drift),
        stribeck_friction=float(effects.stribeck_friction),
        stribeck_velocity=float(effects.stribeck_velocity),
        memory=MEMORY,
    )


def _elastic_strain(tension: float, stiffening: float) -> float:
    """EA ε for which EA ε (1 + κ ε) is ``tension`` [N]; ``stiffening`` is κ/EA [1/N]."""
    return 2.0 * tension / (1.0 + math.sqrt(1.0 + 4.0 * stiffening * tension))
