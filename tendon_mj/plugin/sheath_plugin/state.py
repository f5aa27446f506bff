"""State of a sheath in `mjData.plugin_state`: parameters, committed state, the step on trial.

Everything is there, so copying, saving, resetting and threads need nothing from us. One record of
scalars comes first, then the n+1 segments, the n guides, the points of the path, the arcs, and, in
the first sheath of a model, two forces for each degree of freedom.

The *committed* state is that of the last finished step; every evaluation starts from it and
leaves its result on *trial*; only `advance` makes the trial the committed state.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final, NamedTuple, get_type_hints

import numpy as np

from tendon_mj.native import Array, Record, compiled
from tendon_mj.plugin.abi.layout import Data, Model
from tendon_mj.plugin.abi.memory import address_of, coordinates, copy_doubles, doubles, word
from tendon_mj.plugin.sheath_plugin.servo_friction import ServoFriction
from tendon_mj.sheath import (
    ANY,
    ARC,
    GUIDE,
    LAW,
    SEGMENT,
    Arcs,
    Guides,
    Law,
    Parameter,
    Range,
    Segments,
    parameters_of,
    record_type,
)
from tendon_mj.typing import FloatArray

_DRIVE = {
    "reel_radius": Parameter(
        "r", "m", "radius at which `reel_joint` winds, its sign the sense", ANY
    ),
    "output_radius": Parameter("r", "m", "radius at which `output_joint` winds", ANY),
    "reel_play": Parameter(
        "b", "rad or m", "play between `reel_joint` and the drum of all its cables", Range()
    ),
    "output_play": Parameter(
        "b", "rad or m", "play between `output_joint` and the pulley of all its cables", Range()
    ),
    "output_rest": Parameter(
        "s", "-", "sense, -1 to 1, in which that joint is loaded at `qpos0`; 0: not loaded", ANY
    ),
    "radius": Parameter("r", "m", "cable that a fixed tendon winds per unit of its length", ANY),
    "gear_friction": Parameter(
        "c",
        "-",
        "friction of a gear before a fixed tendon's cable, over the load behind it",
        Range(),
    ),
    "gear_friction_back": Parameter(
        "c_b", "-", "the same where the load drives the motor; not given: c", Range()
    ),
}
# Live parameters in the order of the state, and of the plugin's attributes of the same names.
PARAMETERS: Final = {**LAW, **_DRIVE, **parameters_of(ServoFriction)}


class LiveLaw(Law):
    """The law as the state keeps it: a number for each parameter, 0 if none is given."""

    axial_stiffness: float
    static_friction: float
    pretension: float
    slack: float


class Live:
    """What may be changed while a simulation runs."""

    law: LiveLaw
    reel_radius: float  # [m]
    output_radius: float  # [m]
    reel_play: float  # [the joint's unit]
    output_play: float  # [the joint's unit]
    output_rest: float  # [-]
    radius: float  # [m]
    gear_friction: float  # [-]
    gear_friction_back: float  # [-]
    servo: ServoFriction


class Bound:
    """What a sheath is attached to; indices are −1 for none, flags 0 or 1."""

    tendon: float
    guides: float  # number of guides, with one for each pulley
    arcs: float  # number of geoms that the tendon may wrap around
    arc_guides: float  # number of guides on each of them
    dofs: float  # of the model, in its first sheath; 0 in the others
    inner_guides: float  # number of guides at the input end
    input_at_last: float  # whether that is the last site of the path as it is drawn
    pulleys: float
    branches: float  # signature of which branch feeds which, 0 without a pulley
    fixed: float  # whether the tendon is fixed, and its cable not drawn
    own_spring: float  # whether the tendon's own spring is the cable's elasticity
    driven: float  # whether actuators and the tendon's own spring give the input tension
    inextensible: float  # whether it is driven, and no elasticity is stated
    constrained: float  # whether it is driven, and an equality or a limit may act on the tendon
    spreads: float  # whether that holds the length of the tendon itself
    first_actuator: float  # that acts on the tendon, −1 without one
    last_actuator: float
    reel_joint: float
    output_joint: float
    reel_actuator: float
    first_sensor: float
    last_sensor: float
    first_sheath: float  # instance of the model's first sheath
    last_sheath: float  # and of its last one


class Binding(Bound):
    """What a sheath is attached to, in memory of its own for each `mjData`.

    Nothing that `mj_setState`, `mujoco.rollout` or `MjSpec.recompile` writes is used as an index:
    before each use the state receives a copy of its binding.
    """

    signature: float  # of the model for which this holds
    present: float  # signature of the model as it is now, in the binding of its first sheath
    config_signature: float  # of the attributes
    workspace: float  # address of the groups of all guides, in the binding of the last sheath
    listed_for: float  # signature of the model whose driven sheaths are listed in the workspace
    is_last_plugin: float  # whether no other plugin comes after the last sheath
    push_warned: float  # whether a push was warned of


class State(Bound, Live):
    """Scalars of a sheath: its parameters, a copy of what it is bound to, and the rest."""

    config_signature: float  # of the attributes that the parameters were read from
    input_force: float  # by which MuJoCo acts along the tendon [N], pulling where negative
    applied: float  # whether the last evaluation applied its forces
    witness: float  # index of a number of `cfrc_ext` that has the sheaths' wrenches
    witness_value: float  # what it was with them
    damping_poly_1: float  # work space for MuJoCo
    damping_poly_2: float
    # committed
    started: float  # whether the tendon has been laid along its path
    wound_in: float  # unstretched tendon on the reel [m]
    wound_out: float  # unstretched tendon on the output's spool [m]
    spring_length: float  # rest length of the tendon's own spring [m]
    spring_product: float  # its stiffness times that [N], 0 if EA is not made of it
    finished: float  # whether a step has been finished since the reset
    constraint_force: float  # of equalities and limits of the tendon [N], pulling where negative
    previous_constraint: float  # in the step before [N]
    commit_time: float  # [s]
    unsolved: float  # evaluations without a solution
    warned: float  # whether one has been warned of
    end_sum: float  # of the first sheath: `pose_sum` at the end of the step before
    rebound: float  # times that the state was another model's, or none's
    laid_pretension: float  # under which the tendon was laid [N]
    ratios_vary: float  # whether the ratios were computed for one moment only
    strain_kept: float  # whether the strain law of the step before was another than Hooke's
    speed_kept: float  # whether the guides' speeds were kept in the step before
    slips_kept: float  # whether the speeds of their slips were, by `keep_slips`
    # on trial
    has_trial: float
    trial_wound_in: float  # [m]
    trial_wound_out: float  # [m]
    trial_spring_length: float  # [m]
    trial_time: float  # [s]
    trial_elapsed: float  # time that the step on trial takes [s]
    drum: float  # how far the drum has turned since qpos0 in the last evaluation [joint's unit]
    pulley: float  # likewise [joint's unit]
    reel_torque: float  # by which the last evaluation turned the reel's joint back [N m]
    servo_bound: float  # largest friction inside a servo in the last evaluation [N]
    ratio_law: LiveLaw  # law for which the guides' ratios were computed


STATE, BINDING = record_type(State), record_type(Binding)
_COUNT = STATE.itemsize // 8
_SEGMENT_COUNT, _GUIDE_COUNT = SEGMENT.itemsize // 8, GUIDE.itemsize // 8
_ARC_COUNT = ARC.itemsize // 8
_BOUND_COUNT: Final = len(get_type_hints(Bound))
_BOUND: Final[int] = STATE.fields["tendon"][1]  # type: ignore[index]
WORKSPACE: Final[int] = BINDING.fields["workspace"][1]  # type: ignore[index]
DAMPING_POLY: Final[int] = STATE.fields["damping_poly_1"][1]  # type: ignore[index]
_PARAMETER_COUNT, _LAW_COUNT = len(PARAMETERS), len(LAW)
_RATIO_LAW = _COUNT - _LAW_COUNT  # where the last member begins

state_at: Callable[[int], State] = Record(STATE)
binding_at: Callable[[int], Binding] = Record(BINDING)
_segments_at, _guides_at = Array(SEGMENT), Array(GUIDE)
_arcs_at = Array(ARC)


@compiled
def size_of(guides: int, arcs: int, dofs: int) -> int:
    """Numbers of state of a sheath."""
    tables = _SEGMENT_COUNT * (guides + 1) + _GUIDE_COUNT * guides
    return _COUNT + tables + 3 * (guides + 2) + _ARC_COUNT * arcs + 3 * dofs


@compiled
def fits(bound: Bound, state_size: int) -> bool:
    """Return whether the guides and arcs of a sheath fit into its numbers of state."""
    return size_of(int(bound.guides), int(bound.arcs), int(bound.dofs)) <= state_size


@compiled
def path_counts(state: Bound) -> tuple[float, float, float, float, float, float, float, float]:
    """Counts that two paths have in common where a tendon can lie on one as on the other."""
    return (
        state.guides,
        state.arcs,
        state.arc_guides,
        state.dofs,
        state.inner_guides,
        state.pulleys,
        state.branches,
        state.input_at_last,
    )


@compiled
def clear_step(address: int, state_size: int) -> None:
    """Reset all but the parameters and what the sheath is attached to."""
    doubles(address + 8 * _COUNT, state_size - _COUNT)[:] = 0.0
    state = state_at(address)
    state.started = state.wound_in = state.wound_out = state.commit_time = 0.0
    state.laid_pretension = state.ratios_vary = state.strain_kept = state.speed_kept = 0.0
    state.slips_kept = 0.0
    state.has_trial = state.trial_wound_in = state.trial_wound_out = 0.0
    state.trial_time = state.trial_elapsed = state.reel_torque = state.input_force = 0.0
    state.servo_bound = state.drum = state.pulley = 0.0
    state.applied = state.constraint_force = state.previous_constraint = state.finished = 0.0
    state.ratio_law.axial_stiffness = 0.0  # the ratios are those of no law


@compiled
def unpack(address: int) -> tuple[Segments, Guides, int]:
    """Segments and guides of a sheath, sharing its memory; address of the path."""
    n = int(state_at(address).guides)
    segments = address + 8 * _COUNT
    guides = segments + 8 * _SEGMENT_COUNT * (n + 1)
    path = guides + 8 * _GUIDE_COUNT * n
    return _segments_at(segments, n + 1), _guides_at(guides, n), path


@compiled
def unpack_arcs(address: int) -> Arcs:
    """Arcs of a sheath, sharing its memory."""
    state = state_at(address)
    n = int(state.guides)
    return _arcs_at(address + 8 * size_of(n, 0, 0), int(state.arcs))


@compiled
def unknown_forces(m: Model, d: Data, first: int) -> FloatArray:
    """Forces (nv,) that friction did not know in the last step, as those of constraints [N, N m].

    They are kept in the ``first`` sheath of the model.
    """
    address = state_of(m, d, first)
    state = state_at(address)
    return coordinates(address + 8 * size_of(int(state.guides), int(state.arcs), 0))


@compiled
def known_forces_at(m: Model, d: Data, first: int) -> int:
    """Address of forces (nv,) that friction knows in the step on trial, with its own [N, N m]."""
    address = state_of(m, d, first)
    state = state_at(address)
    after = size_of(int(state.guides), int(state.arcs), 0) + int(state.dofs)
    return address + 8 * after


@compiled
def last_acceleration(m: Model, d: Data, first: int) -> FloatArray:
    """Acceleration (nv,) of the last step, from which it is told which constraints push."""
    return coordinates(known_forces_at(m, d, first) + 8 * m.nv)


@compiled
def parameters_at(address: int) -> FloatArray:
    """Live parameters of a sheath, in the order of ``PARAMETERS``."""
    return doubles(address, _PARAMETER_COUNT)


@compiled
def keep_ratio_law(address: int) -> bool:
    """Store the law as that of the guides' ratios; return whether it already was."""
    law, kept = doubles(address, _LAW_COUNT), doubles(address + 8 * _RATIO_LAW, _LAW_COUNT)
    same = True
    for k in range(_LAW_COUNT):
        same &= kept[k] == law[k]
    if not same:
        copy_doubles(address + 8 * _RATIO_LAW, address, _LAW_COUNT)
    return same


@compiled
def is_wound(state: Bound) -> bool:
    """Return whether a reel or a joint winds the tendon."""
    return state.reel_joint >= 0.0 or state.output_joint >= 0.0 or state.reel_actuator >= 0.0


@compiled
def has_play(state: State) -> bool:
    """Return whether the cable winds on a drum or pulley that has play."""
    at_reel = state.reel_joint >= 0.0 and state.reel_play > 0.0
    return at_reel or (state.output_joint >= 0.0 and state.output_play > 0.0)


@compiled
def tension_unit(state: State) -> float:
    """Tension that a segment's τ = 1 stands for [N]: EA, and 1 N of an inextensible tendon."""
    return 1.0 if state.inextensible != 0.0 else state.law.axial_stiffness


@compiled
def input_strain(state: State) -> float:
    """τ that the force of this evaluation gives the first segment; 0 if it pushes."""
    return max(0.0, -state.input_force) / tension_unit(state)


@compiled
def counted_strain(state: State) -> float:
    """τ of MuJoCo's own pull along the whole tendon, which the sheath's forces replace.

    A force that pushes passes a sheath, but for that of a spring whose tendon is wound: MuJoCo's
    spring does not count the tendon on the drum.
    """
    if state.driven != 0.0:
        return input_strain(state)
    if state.own_spring == 0.0:
        return 0.0
    pull = -state.input_force
    return pull / state.law.axial_stiffness if is_wound(state) or pull > 0.0 else 0.0


@compiled
def adopt_binding(address: int, binding: int) -> None:
    """Copy what a sheath is bound to into its state."""
    copy_doubles(address + _BOUND, binding, _BOUND_COUNT)


@compiled
def state_of(m: Model, d: Data, instance: int) -> int:
    """Address of an instance's state."""
    return address_of(d.plugin_state) + 8 * m.plugin_stateadr[instance]


SHEATH, SENSORS, SERVO = (0x74656E646F6E0001 + k for k in range(3))  # kinds of what is bound


@compiled
def binding_of(d: Data, instance: int, kind: int) -> int:
    """Address of what an instance of a kind is bound to; 0 if nothing of this kind is there.

    With a model whose instances come in another order an instance meets what another was bound to.
    """
    block = d.plugin_data[instance]
    return block + 8 if block != 0 and word(block) == kind else 0


@compiled
def state_size_of(m: Model, instance: int) -> int:
    """How many numbers of state an instance has."""
    return m.plugin_statenum[instance]


class View(NamedTuple):
    """A sheath's state for Python, sharing memory with the numbers that it was read from.

    Attributes:
        state: record with the fields of ``State``.
        segments: (n+1,) records with the fields of ``Segment``.
        guides: (n,) records with the fields of ``Guide``.
        path: (n+2, 3) points for which lengths and bends were computed [m].
    """

    state: Any
    segments: Any
    guides: Any
    path: FloatArray


def view(plugin_states: FloatArray, start: int) -> View:
    """View of the sheath whose state begins at ``start``; axes before the last come first."""

    def take(dtype: np.dtype[Any], count: int) -> Any:
        nonlocal start
        begin, start = start, start + count * dtype.itemsize // 8
        return plugin_states[..., begin:start].view((np.record, dtype))

    scalars = take(STATE, 1)
    state = scalars[0] if plugin_states.ndim == 1 else scalars[..., 0]
    n = int(scalars["guides"].flat[0])
    segments, guides = take(SEGMENT, n + 1), take(GUIDE, n)
    path = plugin_states[..., start : start + 3 * (n + 2)]
    return View(state, segments, guides, path.reshape(*path.shape[:-1], n + 2, 3))
