"""Records that hold a tendon at one moment: one per segment, one per guide.

Guide i sits between segment i (input side) and segment i+1 (output side). Tensions are normalised,
τ = T/EA. In compiled code a field is read as ``segments[j].tension``; in Python an array of records
gives a field of all of them as ``segments["tension"]``.

The solver alone and a simulation share these records: a compiled function has one version then, and
files that Numba cached in different processes cannot mix up versions of it.
"""

from __future__ import annotations

from typing import Any, Protocol, TypeAlias, TypeVar, cast, get_type_hints, overload

import numpy as np
from numpy.typing import ArrayLike

from tendon_mj.typing import FloatArray

_R = TypeVar("_R", covariant=True)


class Segment:
    """A stretch of tendon between two guides.

    The fields up to ``tension`` are the flow solver's. The others belong to the strain law
    of a simulation and stay 0 elsewhere: the tension before the step, the strains kept while
    damping, stiffening or creep asks for them, and those of the step on trial.
    """

    length: float  # ℓ, geometric length [m]
    support_compliance: float  # g, length that a support at the end gives up per unit τ [m]
    strain_offset: float  # d, strain that no tension causes (damping, creep, stiffening) [-]
    strain_slope: float  # a, strain that comes with unit τ; 1 for a purely elastic tendon [-]
    stored: float  # s⁻, unstretched length before the step [m]
    tension: float  # τ, a guess on entry, the result on return [-]
    strain: float  # elastic strain [-]
    new_strain: float  # that of the evaluation at hand [-]
    trial_strain: float  # that of the step on trial [-]
    creep_strain: float  # [-]
    trial_creep_strain: float  # [-]
    previous_tension: float  # τ after the step before, from which the solver starts [-]
    trial_tension: float  # [-]
    # its one straight span, and what that does to the bodies at its ends
    point: float  # of the tendon's path, where the span begins; −1 without one
    near_body: float
    far_body: float
    divisor: float  # of the pulley before this branch [-]
    unshifted: float  # unstretched length before the arcs' guides moved along the tendon [m]
    trial_yield: float  # by which its guides have yielded in the step on trial [m]


class Guide:
    """A point at which the tendon bends and rubs.

    The fields up to ``slip`` are the flow solver's. The others belong to a simulation.
    """

    static_ratio: float  # e^{μ_s φ}, largest τ_i/τ_{i+1} at rest [-]
    dynamic_ratio: float  # e^{μ_d φ}, that ratio while sliding to the input [-]
    static_ratio_back: float  # largest τ_{i+1}/τ_i at rest, another where μ knows directions [-]
    dynamic_ratio_back: float  # that ratio while sliding to the output [-]
    constant_friction: float  # tension-independent friction over EA [-]
    drag: float  # D, τ that a flow of 1 m in this step takes (viscosity, inertia) [1/m]
    momentum: float  # b, part of it that does not depend on this step's flow [-]
    previous_slip: float  # direction of flow in the step before: +1 to the input, −1, 0 at rest
    input_ratio: float  # largest τ_i/τ_{i+1} that holds now [-]
    output_ratio: float  # largest τ_{i+1}/τ_i that holds now [-]
    flow: float  # unstretched length that passes towards the input in this step [m], result
    slip: float  # direction of that flow, result
    angle: float  # φ, bend [rad]
    ratio_angle: float  # bend for which the ratios were computed [rad]
    friction_work: float  # since the reset [J]
    passed: float  # tendon that has passed to the input since the reset [m]
    sliding_speed: float  # seen through the memory of friction [m/s]
    previous_velocity: float  # in the step before, positive to the input [m/s]
    trial_flow: float  # [m]
    trial_slip: float
    trial_friction_work: float  # [J]
    shift: float  # tendon that its own motion along the tendon hands to the input side [m]
    trial_shift: float  # [m]
    is_pulley: float  # 1 for no guide, but the end of a branch
    is_on_arc: float  # 1 where it is on a geom, which the tendon may leave
    fed_by: float  # segment whose tension the branch behind a pulley takes over, −1: the input's
    # of an inextensible tendon
    ended: float  # speed of its slip after the step before, as in the pose before it [m/s], if kept
    way: float  # length from the guide to the output end [m]
    trial_way: float  # [m]


class Arc:
    """A stretch of tendon on a sphere or cylinder, between two tangent points.

    The points are in the frame of the geom: what moves against it there has moved along the drum.
    """

    touches: float  # whether the tendon lay on it after the last finished step
    x1: float  # [m]
    y1: float
    z1: float
    x2: float
    y2: float
    z2: float
    trial_touches: float
    trial_x1: float
    trial_y1: float
    trial_z1: float
    trial_x2: float
    trial_y2: float
    trial_z2: float


class Records(Protocol[_R]):
    """An array of records."""

    @overload
    def __getitem__(self, index: int) -> _R: ...
    @overload
    def __getitem__(self, index: str) -> FloatArray: ...
    @overload
    def __getitem__(self, index: slice) -> Records[_R]: ...
    def __setitem__(self, index: str, values: ArrayLike) -> None: ...
    def __len__(self) -> int: ...


Segments: TypeAlias = Records[Segment]
Guides: TypeAlias = Records[Guide]
Arcs: TypeAlias = Records[Arc]


def record_type(described: type) -> np.dtype[Any]:
    """NumPy's type for the annotated fields of a class: float64, or records of their own.

    Its fields are attributes in Python too, in which NUMBA_DISABLE_JIT has the solver run.
    """
    hints = get_type_hints(described)
    members: list[Any] = [
        (name, np.float64 if kind is float else record_type(kind)) for name, kind in hints.items()
    ]
    return np.dtype((np.record, np.dtype(members, align=True)))


SEGMENT = record_type(Segment)
GUIDE = record_type(Guide)
ARC = record_type(Arc)

# What rounding leaves uncertain of a strain, and so of τ, when it is the difference ℓ/s − 1.
ROUNDING = 5e-16


def new_segments(count: int) -> Segments:
    """Segments with every field 0."""
    return cast(Segments, np.zeros(count, SEGMENT))


def new_guides(count: int) -> Guides:
    """Guides with every field 0."""
    return cast(Guides, np.zeros(count, GUIDE))
