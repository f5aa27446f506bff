"""Checks of a model in compiled code, for programs without Python.

They refuse by `mju_error` what the plugins could not act on, with the instance, the attribute, its
value and what it has to be; `mj_loadXML` returns the sentence. In Python the checks of `validate`
take their place, which look at more and say more.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import mujoco
import numpy as np
from numpy.typing import NDArray

from tendon_mj.native import LocalDoubles, Text, apart, compiled
from tendon_mj.plugin.abi.layout import Data, Model, data_at
from tendon_mj.plugin.abi.library import (
    append,
    mj_deleteData,
    mju_error,
    plugin_name,
    read_number,
)
from tendon_mj.plugin.abi.memory import address_of, letters, word
from tendon_mj.plugin.servo_plugin import state as sv
from tendon_mj.plugin.sheath_plugin import attributes as at
from tendon_mj.plugin.sheath_plugin.fixed_tendon import is_fixed
from tendon_mj.plugin.sheath_plugin.input_force import acts_on, has_spring
from tendon_mj.plugin.sheath_plugin.names import own_name, resolve, resolve_from
from tendon_mj.plugin.sheath_plugin.path import NOT_GIVEN, capacity
from tendon_mj.plugin.sheath_plugin.state import (
    PARAMETERS,
    Bound,
    fits,
    is_wound,
    size_of,
    state_size_of,
)
from tendon_mj.sheath import Parameter
from tendon_mj.typing import FloatArray

_JOINT, _TENDON = mujoco.mjtObj.mjOBJ_JOINT.value, mujoco.mjtObj.mjOBJ_TENDON.value
_SLIDE = mujoco.mjtJoint.mjJNT_SLIDE.value  # before it come joints of several degrees of freedom
_MOST_STATE = 2**24  # numbers of a sheath
_WIDTH = 96  # of a reason, in bytes


def _bounds(parameters: Mapping[str, Parameter]) -> FloatArray:
    """Of each: lowest value, whether allowed itself, value to stay below, whether required."""
    rows = [(p.range.low, p.range.closed, p.range.high, p.required) for p in parameters.values()]
    return np.array(rows, float)


def _reasons(parameters: Mapping[str, Parameter]) -> NDArray[np.uint8]:
    return at.as_rows((f" must be {p.range}" for p in parameters.values()), _WIDTH)


_SHEATH_BOUNDS, _SHEATH_REASONS = _bounds(PARAMETERS), _reasons(PARAMETERS)
_SERVO_BOUNDS, _SERVO_REASONS = _bounds(sv.GAINS), _reasons(sv.GAINS)
_SHEATH_NAMES, _SERVO_NAMES = at.as_rows(at.ATTRIBUTES), at.as_rows(sv.ATTRIBUTES)
_FEEDBACKS, _SWITCH = at.as_rows(sv.FEEDBACKS), at.as_rows(sv.SWITCH)
_SHEATH_PLUGIN = at.as_rows(("tendon_mj.sheath",))
_STATIC = at.FIRST_PARAMETER + list(PARAMETERS).index("static_friction")
_FRICTION = at.FIRST_PARAMETER + list(PARAMETERS).index("friction")
_RADII = [
    at.FIRST_PARAMETER + list(PARAMETERS).index(name)
    for name in ("reel_radius", "output_radius", "radius")
]
_REEL_RADIUS, _OUTPUT_RADIUS, _RADIUS = _RADII
# index of the parameter without which a parameter has no effect, −1 for none
_SCALES = np.array(
    [list(PARAMETERS).index(p.scale) if p.scale else -1 for p in PARAMETERS.values()]
)
_PERIOD, _DELAY = list(sv.GAINS).index("period"), list(sv.GAINS).index("delay")

_SIZE = 1024  # bytes of a message, with the zero that ends it
_buffer = LocalDoubles(_SIZE // 8)
_end = LocalDoubles(1)
_space, _instance, _quote, _equals = Text(" instance '"), Text("': "), Text("'"), Text(" = '")
_missing = Text(" is missing")
_no_number = Text(" is not a number")
_no_count = Text(" must be a count up to 999999")
_unknown_word = Text(" is not one of its words")
_no_tendon = Text(" is not a tendon of the model")
_no_sheath = Text(" has no sheath with a reel_joint")
_no_joint = Text(" is not a hinge or slide of the model")
_undriven = Text(" is a fixed tendon, and no actuator acts on it or on its one joint")
_not_one = Text(" must be 1 on a fixed tendon")
_second = Text(" already runs in another sheath")
_slips = Text(" must not be below friction")
_too_large = Text(" takes more state than there may be")
_other_count = Text(" is not the number of guides of the tendon's path")
_no_radius = Text(" needs its radius")
_no_spring = Text(" needs a stiffness of the tendon")
_pulled_twice = Text(" is wound or its own spring, and something else pulls on it as a whole")
_branches = Text(" branches at a pulley, which only a driven one with its first site as input may")
_no_scale = Text(" has no effect without the parameter that scales it")
_nothing = Text(" must not be 0")
_no_stiffness = Text(" is missing, as nothing pulls the tendon")
_binary, _nothing_given = Text("the binary model"), Text("")
_other_slots = Text(
    " is of a program with another plugin in this slot: load its MJCF instead, or first the same"
    " plugins in the same order"
)


@apart
def _refuse(m: Model, d: int, instance: int, attribute: int, value: int, reason: int) -> None:
    """Raise ``plugin instance 'name': attribute = 'value' reason``, each at an address.

    The data at ``d`` of `init`, if not 0, is deleted: MuJoCo does not free it.
    """
    message, used = _buffer(), 0
    plugin = plugin_name(m, instance)
    used = append(message, used, plugin, _SIZE // 4)
    used = append(message, used, _space(), _SIZE // 4)
    name = own_name(m, instance)
    if name != 0:
        used = append(message, used, name, _SIZE // 2)
    used = append(message, used, _instance(), _SIZE - 1)
    used = append(message, used, attribute, _SIZE - 1)
    if letters(value)[0] != 0:
        used = append(message, used, _equals(), _SIZE - 1)
        used = append(message, used, value, _SIZE - _SIZE // 4)
        used = append(message, used, _quote(), _SIZE - 1)
    used = append(message, used, reason, _SIZE - 1)
    letters(message)[used] = 0
    if d != 0:
        data_at(d).nplugin = instance  # only those before it have begun
        mj_deleteData(d)
    mju_error(message)


@apart
def refuse_slot(m: Model, d: int, instance: int) -> None:
    """Refuse an instance in the slot of a placeholder; ``d`` as in `_refuse`."""
    _refuse(m, d, instance, _binary(), _nothing_given(), _other_slots())


@compiled
def _row(rows: NDArray[np.uint8], k: int) -> int:
    """Address of a row of text."""
    return rows[k].ctypes.data


@compiled
def _refuse_of_sheath(m: Model, instance: int, attribute: int, reason: int, d: int = 0) -> None:
    value = at.text_at(m, instance, attribute)
    _refuse(m, d, instance, _row(_SHEATH_NAMES, attribute), value, reason)


@compiled
def _refuse_of_servo(m: Model, instance: int, attribute: int, reason: int) -> None:
    value = at.text_at(m, instance, attribute)
    _refuse(m, 0, instance, _row(_SERVO_NAMES, attribute), value, reason)


@apart
def _is_number(text: int) -> bool:
    """Whether a text that is not empty is a number to its end."""
    end = _end()
    read_number(text, end)
    after = word(end)
    return after != text and letters(after)[0] == 0


@apart
def _is_admitted(bounds: FloatArray, k: int, value: float) -> bool:
    """Whether a value is finite and within the range of a parameter."""
    low, closed, high = bounds[k, 0], bounds[k, 1] != 0.0, bounds[k, 2]
    above = value > low or (closed and value == low)
    return math.isfinite(value) and above and value < high


@apart
def _count(m: Model, instance: int, attribute: int, otherwise: int) -> int:
    """A count that is given as an attribute of a sheath."""
    text, count, digits = at.text_at(m, instance, attribute), 0, 0
    while 48 <= letters(text)[digits] <= 57 and digits < 7:
        count = 10 * count + letters(text)[digits] - 48
        digits += 1
    if letters(text)[0] == 0:
        return otherwise
    if digits > 6 or letters(text)[digits] != 0:
        _refuse_of_sheath(m, instance, attribute, _no_count())
    return count


@apart
def _check_spool(m: Model, instance: int, joint: int, radius: int) -> None:
    """Refuse a joint of a spool that is none, or has no radius."""
    if at.is_given(m, instance, radius) and not at.is_given(m, instance, joint):
        _refuse_of_sheath(m, instance, joint, _missing())
    if at.is_given(m, instance, joint) and not at.is_given(m, instance, radius):
        _refuse_of_sheath(m, instance, joint, _no_radius())
    if at.is_given(m, instance, radius) and at.number(m, instance, radius) == 0.0:
        _refuse_of_sheath(m, instance, radius, _nothing())
    if at.is_given(m, instance, joint):
        index = resolve(m, instance, joint, _JOINT)
        if index < 0 or m.jnt_type[index] < _SLIDE:
            _refuse_of_sheath(m, instance, joint, _no_joint())


@apart
def _check_word(m: Model, instance: int, attribute: int, known: NDArray[np.uint8]) -> None:
    given = at.is_given(m, instance, attribute)
    if given and at.index_of(at.text_at(m, instance, attribute), known) < 0:
        _refuse_of_sheath(m, instance, attribute, _unknown_word())


@apart
def sheath_state(m: Model, instance: int) -> int:
    """Check the attributes of a sheath or sensor; numbers of its state."""
    _check_word(m, instance, at.SENSOR, at.KIND_NAMES)
    is_named = at.is_given(m, instance, at.TENDON) or not at.is_sensor(m, instance)
    if is_named and resolve(m, instance, at.TENDON, _TENDON) < 0:
        _refuse_of_sheath(m, instance, at.TENDON, _no_tendon())
    if at.is_sensor(m, instance):
        return 1
    for k in range(len(_SHEATH_BOUNDS)):
        _check_parameter(m, instance, k)
    friction, static = at.number(m, instance, _FRICTION), at.number(m, instance, _STATIC)
    if at.is_given(m, instance, _STATIC) and static < friction:
        _refuse_of_sheath(m, instance, _STATIC, _slips())
    _check_word(m, instance, at.INPUT_END, at.END_NAMES)
    _check_word(m, instance, at.SPRING, at.SPRING_NAMES)
    _check_spool(m, instance, at.REEL_JOINT, _REEL_RADIUS)
    _check_spool(m, instance, at.OUTPUT_JOINT, _OUTPUT_RADIUS)
    return _state_size(m, instance)


@apart
def _check_parameter(m: Model, instance: int, k: int) -> None:
    """Refuse a number of a sheath that is missing, none, out of range, or without its scale."""
    attribute = at.FIRST_PARAMETER + k
    text = at.text_at(m, instance, attribute)
    if letters(text)[0] == 0:
        if _SHEATH_BOUNDS[k, 3] != 0.0 and attribute != at.AXIAL_STIFFNESS:
            _refuse_of_sheath(m, instance, attribute, _missing())
        return
    if not _is_number(text):
        _refuse_of_sheath(m, instance, attribute, _no_number())
    if not _is_admitted(_SHEATH_BOUNDS, k, at.number_at(text)):
        _refuse_of_sheath(m, instance, attribute, _row(_SHEATH_REASONS, k))
    scaled = _SCALES[k] >= 0 and at.number_at(text) != 0.0
    if scaled and at.number(m, instance, at.FIRST_PARAMETER + _SCALES[k]) == 0.0:
        _refuse_of_sheath(m, instance, attribute, _no_scale())


@apart
def _capacity(m: Model, instance: int) -> tuple[int, int]:
    """Guides and arcs of a sheath to allocate memory for."""
    each = _count(m, instance, at.ARC_GUIDES, NOT_GIVEN)
    if each == 0:
        _refuse_of_sheath(m, instance, at.ARC_GUIDES, _no_count())
    guides = _count(m, instance, at.GUIDES, NOT_GIVEN)
    return capacity(m, guides, each, _count(m, instance, at.INNER_GUIDES, 0))


@apart
def _state_size(m: Model, instance: int) -> int:
    """Numbers of state of a sheath."""
    guides, arcs = _capacity(m, instance)
    leads = at.first_sheath(m, instance) == instance
    numbers = size_of(guides, arcs, m.nv if leads else 0)
    if numbers > _MOST_STATE:
        _refuse_of_sheath(m, instance, at.GUIDES, _too_large())
    return numbers


@apart
def check_bound(m: Model, d: Data, instance: int, bound: Bound) -> None:
    """Refuse a sheath that cannot act on its tendon; the model is complete."""
    tendon = resolve(m, instance, at.TENDON, _TENDON)
    if is_fixed(m, tendon):
        if bound.driven == 0.0:
            _refuse_of_sheath(m, instance, at.TENDON, _undriven(), address_of(d))
        if at.number(m, instance, at.INNER_GUIDES) != 1.0:
            _refuse_of_sheath(m, instance, at.INNER_GUIDES, _not_one(), address_of(d))
        if at.number(m, instance, _RADIUS) == 0.0:
            _refuse_of_sheath(m, instance, _RADIUS, _nothing(), address_of(d))
    for other in range(instance):
        if at.is_sheath(m, other, instance) and resolve(m, other, at.TENDON, _TENDON) == tendon:
            _refuse_of_sheath(m, instance, at.TENDON, _second(), address_of(d))
    _check_path(m, d, instance, bound)
    _check_pull(m, d, instance, bound, tendon)


@apart
def _check_path(m: Model, d: Data, instance: int, bound: Bound) -> None:
    """Refuse counts that are not those of the path, and branches where they cannot be."""
    if bound.tendon < 0.0 or not fits(bound, state_size_of(m, instance)):
        _refuse_of_sheath(m, instance, at.GUIDES, _other_count(), address_of(d))
    if at.is_given(m, instance, at.GUIDES):
        if bound.guides != _count(m, instance, at.GUIDES, 0):
            _refuse_of_sheath(m, instance, at.GUIDES, _other_count(), address_of(d))
        if bound.arcs > 0.0 and not at.is_given(m, instance, at.ARC_GUIDES):
            _refuse_of_sheath(m, instance, at.ARC_GUIDES, _missing(), address_of(d))
    if bound.pulleys > 0.0 and (bound.driven == 0.0 or bound.input_at_last != 0.0):
        _refuse_of_sheath(m, instance, at.TENDON, _branches(), address_of(d))


@apart
def _check_pull(m: Model, d: Data, instance: int, bound: Bound, tendon: int) -> None:
    """Refuse a tendon that is pulled in two ways, or in none without a stiffness."""
    is_cable, sprung = bound.own_spring != 0.0, has_spring(m, tendon)
    if is_cable and not sprung:
        _refuse_of_sheath(m, instance, at.SPRING, _no_spring(), address_of(d))
    if is_wound(bound) and sprung and not is_cable:
        _refuse_of_sheath(m, instance, at.TENDON, _pulled_twice(), address_of(d))
    for actuator in range(m.nactuator):
        pulls = acts_on(m, actuator, tendon) and m.actuator_plugin[actuator] != instance
        if pulls and (is_wound(bound) or is_cable):
            _refuse_of_sheath(m, instance, at.TENDON, _pulled_twice(), address_of(d))
    has_stiffness = is_cable or at.is_given(m, instance, at.AXIAL_STIFFNESS)
    if bound.driven == 0.0 and not has_stiffness:
        _refuse_of_sheath(m, instance, at.AXIAL_STIFFNESS, _no_stiffness(), address_of(d))


@apart
def sensor_width(m: Model, instance: int) -> int:
    """Numbers of a sensor on an instance."""
    if not at.is_sensor(m, instance):
        return at.ENDS
    kind, tendon = at.sensor_kind(m, instance), resolve(m, instance, at.TENDON, _TENDON)
    for other in range(m.nplugin):
        if at.is_sheath(m, other, instance) and resolve(m, other, at.TENDON, _TENDON) == tendon:
            return at.numbers_of(kind, _capacity(m, other)[0])
    return 1


@apart
def servo_state(m: Model, instance: int) -> int:
    """Check the attributes of a servo; numbers of its state."""
    for k in range(len(_SERVO_BOUNDS)):
        text = at.text_at(m, instance, k)
        if letters(text)[0] == 0:
            if _SERVO_BOUNDS[k, 3] != 0.0:
                _refuse_of_servo(m, instance, k, _missing())
        elif not _is_number(text):
            _refuse_of_servo(m, instance, k, _no_number())
        elif not _is_admitted(_SERVO_BOUNDS, k, at.number_at(text)):
            _refuse_of_servo(m, instance, k, _row(_SERVO_REASONS, k))
    feedback, backdrive = (
        at.text_at(m, instance, sv.FEEDBACK),
        at.text_at(m, instance, sv.BACKDRIVE),
    )
    if letters(feedback)[0] != 0 and at.index_of(feedback, _FEEDBACKS) < 0:
        _refuse_of_servo(m, instance, sv.FEEDBACK, _unknown_word())
    if letters(backdrive)[0] != 0 and at.index_of(backdrive, _SWITCH) < 0:
        _refuse_of_servo(m, instance, sv.BACKDRIVE, _unknown_word())
    tendon = resolve_from(m, instance, sv.TENDON, sv.INSTANCE, sv.TENDON, _TENDON)
    if tendon < 0:
        _refuse_of_servo(m, instance, sv.TENDON, _no_tendon())
    if not _has_motor(m, tendon):
        _refuse_of_servo(m, instance, sv.TENDON, _no_sheath())
    period, delay = at.number(m, instance, _PERIOD), at.number(m, instance, _DELAY)
    commands = sv.capacity(period, delay, m.opt.timestep)
    if commands > sv.MOST_COMMANDS:
        _refuse_of_servo(m, instance, _DELAY, _too_large())
    return sv.size_of(commands)


@apart
def _has_motor(m: Model, tendon: int) -> bool:
    """Whether a tendon has a sheath whose input a joint winds."""
    for other in range(m.nplugin):
        if at.index_of(plugin_name(m, other), _SHEATH_PLUGIN) != 0 or at.is_sensor(m, other):
            continue
        if resolve(m, other, at.TENDON, _TENDON) == tendon:
            return resolve(m, other, at.REEL_JOINT, _JOINT) >= 0
    return False
