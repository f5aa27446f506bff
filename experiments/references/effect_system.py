"""A chain with effects as the compiled functions take it: parameters, and records of its state.

Nodes are the n elements and behind them the carriages; spring j lies before element j + 1, spring
n behind the last element. Displacements are positive toward the input. Each node, element and
spring is one record of an array, whose named fields Numba compiles to plain memory; with a
structure of many arrays a step took twice as long, for the references that every loop counts.

Equations: docs/theory.md, section 5.
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
import numpy.typing as npt

RecordArray = npt.NDArray[np.void]

NODE: Final = np.dtype(
    [
        ("mass", np.float64),  # [kg]
        ("damping", np.float64),  # against the ground [N s/m]
        ("displacement", np.float64),  # [m]
        ("increment", np.float64),  # d, displacement within the last step [m]
        ("velocity", np.float64),  # at the end of the last step [m/s]
        ("previous_velocity", np.float64),  # at its beginning [m/s]
        ("smooth_steps", np.int64),  # since the element last stopped, started or turned
        ("inertia", np.float64),  # inertia force per d [N/m]
        ("inertia_offset", np.float64),  # inertia force at d = 0 [N]
        ("rate", np.float64),  # velocity per d [1/s]
        ("rate_offset", np.float64),  # velocity at d = 0 [m/s]
        ("lower", np.float64),  # of the tridiagonal system for d [N/m]
        ("diagonal", np.float64),
        ("upper", np.float64),
        ("load", np.float64),  # its right side [N]
    ]
)
ELEMENT: Final = np.dtype(
    [
        ("angle", np.float64),  # φ_i [rad]
        ("static", np.float64),  # μ_s [–]
        ("dynamic", np.float64),  # μ_d [–]
        ("constant", np.float64),  # F_c/n [N]
        ("static_to_input", np.float64),  # T_high/T_low up to which it rests [–]
        ("static_to_output", np.float64),
        ("sliding_to_input", np.float64),  # T_high/T_low while it slides [–]
        ("sliding_to_output", np.float64),
        ("frictionless", np.bool_),  # rubs in neither direction
        ("direction", np.int64),  # of sliding, +1 toward the input, 0 at rest
        ("previous_direction", np.int64),  # a step before
        ("held", np.bool_),  # was stopped in this step
        ("sliding_speed", np.float64),  # w [m/s]
    ]
)
SPRING: Final = np.dtype(
    [
        ("stiffness", np.float64),  # k [N/m]
        ("tension", np.float64),  # [N]
        ("previous_tension", np.float64),  # a step before [N]
        ("creep_strain", np.float64),  # EA ε_c [N]
        ("next_creep_strain", np.float64),  # predicted for the end of the step [N]
        ("input_slope", np.float64),  # derivative of the tension in the node before it [N/m]
        ("output_slope", np.float64),  # minus that in the node behind it [N/m]
        ("linear_tension", np.float64),  # were it linear within the step [N]
    ]
)
CARRIAGE: Final = np.dtype(
    [
        ("stiffness", np.float64),  # of the spring behind it [N/m]
        ("damping", np.float64),  # beside that spring [N s/m]
    ]
)


class Material(NamedTuple):
    """Law of the tendon, T = EA ε_e (1 + κ ε_e) + EA τ_r dε/dt with ε = ε_e + ε_c.

    Attributes:
        pretension: T_0 [N].
        compliance: 1/EA, strain per newton [1/N]; 0 is infinitesimal strain.
        initial_strain: EA ε under T_0, elastic and delayed [N].
        stiffening: κ [–].
        creep: χ [–].
        creep_time: τ_c [s].
        retardation_time: τ_r [s].
    """

    pretension: float
    compliance: float
    initial_strain: float
    stiffening: float
    creep: float
    creep_time: float
    retardation_time: float


class Friction(NamedTuple):
    """Friction parameters that all elements share.

    Attributes:
        viscous: c_v/n [N s/m].
        asymmetry: α [–].
        gradient: γ [1/m].
        drift: β [1/s].
        stribeck_friction: Δμ [–].
        stribeck_velocity: v_s [m/s].
        memory: of the sliding speed [s].
    """

    viscous: float
    asymmetry: float
    gradient: float
    drift: float
    stribeck_friction: float
    stribeck_velocity: float
    memory: float


class EffectChain(NamedTuple):
    """Chain of elements with effects, and the carriages behind it, in the state it has reached.

    Attributes:
        material: law of the tendon.
        friction: of the elements.
        preload: tension that the carriages' springs balance at the start [N].
        mount_compliance: C_s, of the sheath's mount at the input [m/N].
        output_compliance: of a massless output, where there is no carriage [m/N].
        backlash: b [m].
        nodes: of type ``NODE``. Shape (n + carriages,).
        elements: of type ``ELEMENT``. Shape (n,).
        springs: of type ``SPRING``. Shape (n + 1,).
        carriages: of type ``CARRIAGE``. Shape (carriages,).
    """

    material: Material
    friction: Friction
    preload: float
    mount_compliance: float
    output_compliance: float
    backlash: float
    nodes: RecordArray
    elements: RecordArray
    springs: RecordArray
    carriages: RecordArray
