"""Gains of a servo, and its state in `mjData.plugin_state`: memory, commands on their way.

As for the sheath there is a *committed* state, from which every evaluation starts, and one on
*trial*, which the last evaluation leaves for `advance`. A ring of commands follows the scalars.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, Final, SupportsFloat, TypeAlias, TypedDict, get_type_hints

import numpy as np

from tendon_mj.native import Array, LocalDoubles, Record, compiled
from tendon_mj.plugin.abi.memory import copy_doubles, doubles
from tendon_mj.sheath import (
    POSITIVE,
    Parameter,
    Records,
    check_in_range,
    described,
    parameters_of,
    record_type,
    with_parameters,
)
from tendon_mj.typing import FloatArray


@with_parameters
class Gains:
    """Parameters of a servo, in the order of its state and of the plugin's attributes.

    None: taken from elsewhere. A limit or a stiffness of 0 is none, that is without end.
    """

    tension_gain: float = described("G_t", "-", "gain of the tension", POSITIVE)
    velocity_gain: float = described("G_v", "N m s/rad", "damping of the motor's speed")
    loosening_tension_gain: float | None = described(
        "G_t", "-", "gain while paying out, default tension_gain", POSITIVE, default=None
    )
    loosening_velocity_gain: float | None = described(
        "G_v", "N m s/rad", "damping while paying out, default velocity_gain", default=None
    )
    motor_inertia: float | None = described(
        "J_m", "kg m²", "inertia, default the joint's armature", POSITIVE, default=None
    )
    torque_limit: float = described("τ_max", "N m", "largest torque, 0: no limit", default=0.0)
    speed_limit: float = described("ω_max", "rad/s", "largest speed, 0: no limit", default=0.0)
    period: float = described(
        "Δ", "s", "time between samples of the controller, 0: every time step", default=0.0
    )
    delay: float = described("d", "s", "time from a sample to its torque", default=0.0)
    observer_friction: float | None = described(
        "μ", "-", "friction of observer and feed-forward, default the sheath's", default=None
    )
    output_stiffness: float = described(
        "k_se", "N/m", "stiffness of the feed-forward, 0: rigid", default=0.0
    )
    backlash_feedforward: float = described(
        "f_b", "-", "1 crosses the backlash at once when T_r turns back", default=0.0
    )
    rate_feedforward: float = described(
        "f_r", "-", "1 adds the speed that a changing T_r asks for", default=0.0
    )
    reversal_band: float = described(
        "B", "N", "change of T_r that counts as turning back", default=0.0
    )


class OptionalGains(TypedDict, total=False):
    """Parameters of `Gains` that a call may leave out, for type checkers: they read no metadata."""

    loosening_tension_gain: SupportsFloat | None
    loosening_velocity_gain: SupportsFloat | None
    motor_inertia: SupportsFloat | None
    torque_limit: SupportsFloat | None
    speed_limit: SupportsFloat | None
    period: SupportsFloat | None
    delay: SupportsFloat | None
    observer_friction: SupportsFloat | None
    output_stiffness: SupportsFloat | None
    backlash_feedforward: SupportsFloat | None
    rate_feedforward: SupportsFloat | None
    reversal_band: SupportsFloat | None


GAINS: Final[dict[str, Parameter]] = parameters_of(Gains)


def check_gain(name: str, value: float, where: str) -> None:
    """Refuse a servo's parameter outside its range.

    Raises:
        InvalidValueError: names the parameter, the value, its range and unit.
    """
    check_in_range(GAINS, name, value, where)


SERVO: Final = "tendon_mj.servo"  # name of the plugin
ATTRIBUTES: Final = (*GAINS, "tendon", "feedback", "backdrive", "instance")
TENDON, FEEDBACK, BACKDRIVE = range(len(GAINS), len(ATTRIBUTES) - 1)
FEEDBACKS: Final = ("sensor", "observer")
SWITCH: Final = ("false", "true")


class LiveGains(Gains):
    """The gains as the state keeps them: a number for each."""

    loosening_tension_gain: float
    loosening_velocity_gain: float
    motor_inertia: float
    observer_friction: float


class Memory:
    """Memory of a servo from one sample to the next."""

    estimate: float  # T̂_out, the output tension as the motor side knows it [N]
    turned_at: float  # extreme of the reference since it last turned [N]
    sense: float  # where the reference goes: +1 pulls, −1 loosens, 0 has not moved yet
    crossing: float  # 1 while the backlash of the last reversal is being crossed
    mark: float  # output tension from which it has to move for the crossing to be over [N]
    reference: float  # the last one [N]
    time: float  # when that was [s]


class Live:
    """What may be changed while a simulation runs."""

    gains: LiveGains


class Bound:
    """What a servo is attached to; indices are −1 for none."""

    instance: float  # of the sheath, −1 for none
    sheath: float  # where the sheath's state begins in plugin_state
    actuator: float
    capacity: float  # of the ring


class Binding(Bound):
    """What a servo is attached to, in memory of its own for each `mjData`, like a sheath's."""

    signature: float  # of the model for which this holds
    config_signature: float  # of its attributes and of its sheath's


class State(Bound, Live):
    """Scalars of a servo: gains, a copy of what it is attached to, and the rest."""

    config_signature: float  # of the attributes that the gains were read from
    observes: float  # whether the feedback is the observer's
    backdriven: float  # whether the tendon can turn the motor
    # committed
    started: float
    sample: float  # index of the last sample on the grid of periods
    head: float  # of the ring
    count: float  # of commands in the ring
    # on trial
    has_trial: float
    trial_time: float  # [s]
    sampled: float
    trial_sample: float
    trial_torque: float  # [N m]
    committed: Memory
    trial: Memory


class Command:
    """A torque on its way to the motor."""

    time: float  # of its sample [s]
    torque: float  # [N m]


Commands: TypeAlias = Records[Command]  # in a ring

STATE, MEMORY, COMMAND = record_type(State), record_type(Memory), record_type(Command)
BINDING = record_type(Binding)
_BOUND_COUNT: Final = len(get_type_hints(Bound))
_BOUND: Final[int] = STATE.fields["instance"][1]  # type: ignore[index]
_COUNT, _MEMORY_COUNT, _COMMAND_COUNT = (t.itemsize // 8 for t in (STATE, MEMORY, COMMAND))
TRIAL: Final[int] = STATE.fields["trial"][1]  # type: ignore[index]
_COMMITTED: Final[int] = STATE.fields["committed"][1]  # type: ignore[index]
_GAIN_COUNT = len(GAINS)
state_at: Callable[[int], State] = Record(STATE)
binding_at: Callable[[int], Binding] = Record(BINDING)
_memory_at: Callable[[int], Memory] = Record(MEMORY)
_commands_at = Array(COMMAND)


MOST_COMMANDS: Final = 100_000  # on their way


@compiled
def capacity(period: float, delay: float, timestep: float) -> int:
    """Commands that can be on their way at once; 0 for a servo that acts at once.

    More than `MOST_COMMANDS` are not counted.
    """
    if period == 0.0 and delay == 0.0:
        return 0
    return math.ceil(min(delay / max(period, timestep), 1.0 * MOST_COMMANDS) - 1e-9) + 2


@compiled
def size_of(commands: int) -> int:
    """Numbers that a servo keeps with memory for so many commands."""
    return _COUNT + _COMMAND_COUNT * commands


@compiled
def capacity_of(count: int) -> int:
    """Commands that a state of so many numbers has memory for."""
    return (count - _COUNT) // _COMMAND_COUNT


@compiled
def commands_at(address: int) -> Commands:
    """Ring of commands of the servo whose state is at ``address``."""
    ring: Commands = _commands_at(address + 8 * _COUNT, int(state_at(address).capacity))
    return ring


@compiled
def adopt_binding(address: int, binding: int) -> None:
    """Copy what a servo is attached to into its state."""
    copy_doubles(address + _BOUND, binding, _BOUND_COUNT)


@compiled
def gains_at(address: int) -> FloatArray:
    """Gains of a servo, in the order of ``GAINS``."""
    return doubles(address, _GAIN_COUNT)


scratch_memory: Callable[[], int] = LocalDoubles(_MEMORY_COUNT)  # for what must leave no trace


@compiled
def trial_memory(address: int, place: int) -> Memory:
    """Memory for a step on trial, at a place: a copy of what the last finished step left."""
    copy_doubles(place, address + _COMMITTED, _MEMORY_COUNT)
    return _memory_at(place)


def view(plugin_state: FloatArray, start: int) -> Any:
    """Record of the servo whose state begins at ``plugin_state[start]``, sharing the memory."""
    return plugin_state[start : start + _COUNT].view((np.record, STATE))[0]
