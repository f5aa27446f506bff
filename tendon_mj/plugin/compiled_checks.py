"""Checks of sheaths and servos, once while MuJoCo compiles a model and whenever it makes data.

They are the same for C and for Python. A refusal names the instance, the attribute, its value and a
remedy; `mj_loadXML` returns the sentence. If there is Python, it adds the names that may be
meant, and checks what compiled code does not (`plugin.advice`).

MuJoCo leaves a refusal by a long jump and does not free all that it holds then. Where it asks for
the size of a state it holds a few small lists, between which the heap would fall to pieces: a
refusal is a size of 0 there, and `init` says why. If it asks `init` it holds the data, which is
deleted here.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Final

import mujoco
import numpy as np
from numpy.typing import NDArray

from tendon_mj.errors import INTERRUPTED
from tendon_mj.native import Called, External, LocalDoubles, Shared, Text, apart, compiled
from tendon_mj.plugin.abi.layout import Data, Model
from tendon_mj.plugin.abi.library import (
    RK4,
    append,
    mj_deleteData,
    mj_id2name,
    mju_error,
    plugin_name,
    read_number,
)
from tendon_mj.plugin.abi.memory import letters, word
from tendon_mj.plugin.force_servo_plugin import state as sv
from tendon_mj.plugin.sheath_plugin import attributes as at
from tendon_mj.plugin.sheath_plugin import name_lookup as names
from tendon_mj.plugin.sheath_plugin.fixed_tendon import is_fixed
from tendon_mj.plugin.sheath_plugin.input_force import ON_TENDON, acts_on, has_spring
from tendon_mj.plugin.sheath_plugin.path import NOT_GIVEN, PULLEY, capacity, count_guides
from tendon_mj.plugin.sheath_plugin.servo_friction import ServoFriction
from tendon_mj.plugin.sheath_plugin.state import PARAMETERS, Bound, is_wound, size_of
from tendon_mj.sheath import LARGEST, Parameter, parameters_of
from tendon_mj.typing import FloatArray, IntArray

_OBJ = mujoco.mjtObj
_JOINT, _SITE = _OBJ.mjOBJ_JOINT.value, _OBJ.mjOBJ_SITE.value
_ACTUATOR, _SENSOR = _OBJ.mjOBJ_ACTUATOR.value, _OBJ.mjOBJ_SENSOR.value
_SLIDE = mujoco.mjtJoint.mjJNT_SLIDE.value  # before it come joints of several degrees of freedom
_MOST_STATE = 2**24  # numbers of all sheaths: 128 MiB in each mjData, a third of a million guides
_RUNGE_KUTTA = 2.785293563405282  # where |1 + z + z²/2 + z³/6 + z⁴/24| = 1 on the negative axis


def _sentence(text: str) -> str:
    """A sentence with bytes in the place of an attribute's name and value, and of three texts."""
    return text.format(name="\1", value="\2", a="\3", b="\4", c="\5")


def _says(text: str) -> Text:
    return Text(_sentence(text))


def _rows(sentences: Iterable[str]) -> NDArray[np.uint8]:
    return at.as_rows(map(_sentence, sentences), 192)


class _Numbers:
    """Ranges of parameters and sentences about them, each in the order of the parameters."""

    def __init__(self, parameters: Mapping[str, Parameter]) -> None:
        known = parameters.values()
        ranges = [(p.range.low, p.range.closed, p.range.high, p.range.smallest) for p in known]
        self.ranges: FloatArray = np.array(ranges, float)
        self.outside = _rows(f"{{name}} = {{value}} [{p.unit}] {p.outside()}" for p in known)
        self.extreme = _rows(f"{{name}} = {{value}} [{p.unit}] {p.extreme()}" for p in known)
        self.missing = _rows(  # a sheath that is driven does without a stiffness
            f"{{name}} is missing (its unit is {p.unit})"
            if p.required and name != "axial_stiffness"
            else ""
            for name, p in parameters.items()
        )


_LAW, _GAINS = _Numbers(PARAMETERS), _Numbers(sv.GAINS)
_LAW_RANGES, _LAW_OUTSIDE, _LAW_EXTREME = _LAW.ranges, _LAW.outside, _LAW.extreme
_GAIN_RANGES, _GAIN_OUTSIDE, _GAIN_EXTREME = _GAINS.ranges, _GAINS.outside, _GAINS.extreme
_LAW_MISSING, _GAIN_MISSING = _LAW.missing, _GAINS.missing
_SCALES = np.array(
    [list(PARAMETERS).index(p.scale) if p.scale else -1 for p in PARAMETERS.values()]
)
_UNSCALED = _rows(
    f"{{name}} = {{value}} needs {p.scale} > 0 [{PARAMETERS[p.scale].unit}]" if p.scale else ""
    for p in PARAMETERS.values()
)
_SHEATH_NAMES, _SERVO_NAMES = at.as_rows(at.ATTRIBUTES), at.as_rows(sv.ATTRIBUTES)
_FEEDBACKS, _SWITCH = at.as_rows(sv.FEEDBACKS), at.as_rows(sv.SWITCH)
_PLUGINS = at.as_rows(("tendon_mj.sheath", "tendon_mj.servo"))
_STATIC, _FRICTION, _RADIUS = (
    at.ATTRIBUTES.index(name) for name in ("static_friction", "friction", "radius")
)
_REEL_RADIUS, _REEL_PLAY, _OUTPUT_RADIUS, _OUTPUT_PLAY = (
    at.ATTRIBUTES.index(f"{end}_{name}")
    for end in ("reel", "output")
    for name in ("radius", "play")
)
# of a cable that is not drawn alone
OF_A_DRUM: Final = ("radius", "gear_friction", "gear_friction_back", *parameters_of(ServoFriction))
_OF_A_DRUM = np.array([at.ATTRIBUTES.index(name) for name in OF_A_DRUM])
# what a sheath whose input tension is given has no use for
OF_A_REEL: Final = (
    "pretension", "slack", "backlash", "sheath_compliance", "output_compliance",
    "viscous_friction", "tendon_mass",
)  # fmt: skip
ELASTICITY: Final = ("axial_stiffness", "axial_damping", "stiffening", "creep")
# and a cable that is not drawn: its guide has no place, and two cables no tension of their own
OF_A_PATH: Final = (*ELASTICITY, *OF_A_REEL[1:], "friction_gradient", "load_gradient")
UNDRAWN: Final = ("extra_bend", "constant_friction")  # friction that is not if the path bends
_OF_A_REEL = np.array([at.ATTRIBUTES.index(name) for name in OF_A_REEL])
_OF_A_PATH = np.array([at.ATTRIBUTES.index(name) for name in OF_A_PATH])
_UNDRAWN = np.array([at.ATTRIBUTES.index(name) for name in UNDRAWN])
_PERIOD, _DELAY, _INERTIA = (
    list(sv.GAINS).index(name) for name in ("period", "delay", "motor_inertia")
)
_DAMPINGS = np.array(
    [list(sv.GAINS).index(name) for name in ("velocity_gain", "loosening_velocity_gain")]
)

# names and words of which Python lists those that may be meant
LISTS: Final = (
    *("tendon", "sheathed tendon", "joint", "sensor", "input_end", "spring"),
    *("feedback", "backdrive"),
)
TENDONS, SHEATHED, JOINTS, KINDS, ENDS, SPRINGS, FEEDBACKS, SWITCH = range(len(LISTS))
MORE: Final = -1  # checks that Python makes in the place of a list
ADVICE: Final = "tendon_mj_advice"
_advice = Shared(ADVICE, 1)  # address of a function in Python; 0 without one
_ask = Called("void(ptr, ptr, i32, ptr)")

GIVEN: Final = (
    "has no meaning where an actuator, a spring, an equality or a limit gives the input tension of"
    " tendon {}"
)
NOT_DRAWN: Final = "has no meaning on tendon {}, which is fixed: its cable is not drawn"
DRAWN: Final = "has no meaning on a tendon that is drawn"
_SIZE = 2048  # bytes of a message, with the zero that ends it
_HALF = _SIZE // 2  # of them without the names that may be meant
message = LocalDoubles(_SIZE // 8)  # in which the first byte has to be set to 0
_end = LocalDoubles(1)
_digits = LocalDoubles(4)
_gcvt = External("gcvt", "ptr(f64, i32, ptr)")
_plugin, _instance, _quote, _colon = Text("plugin "), Text(" instance '"), Text("'"), Text(": ")
_none, _interrupted = Text(""), Text(f"tendon_mj: {INTERRUPTED}")
_unknown_word = _says("unknown {name} '{a}'")
_unknown_tendon = _says("unknown tendon '{a}'")
_unknown_joint = _says("{name}: unknown joint '{a}'")
_unknown_object = _says("sensor '{b}': unknown sheathed tendon '{a}'")
_no_number = _says("{name} = '{value}' is not a number")
_no_count = _says("{name} = '{value}' must be a count up to 999999")
_no_arc = _says("{name} = {value} must be 1 or more")
_not_of_a_sensor = _says("{name} = {value}: a sensor takes no {name}; the sheath has it")
_unsized = _says(
    "unknown sheathed tendon '{a}', and {name} is missing, on which the size of a sensor of {b}"
    " depends"
)
_second = _says("tendon '{value}' already runs in sheath '{a}'; a tendon has one sheath")
_slips = _says("{name} = {value} must be ≥ friction = {a}")
_together = _says("{name} and {a} go together, one of them is missing")
_no_radius = _says("{name} = {value} [m] must be finite and not 0")
_no_spool = _says("{name} '{value}' is not a hinge or slide")
_too_large = _says(
    "{name} = {value}: all sheaths take {a} numbers of state, more than 16777216; give `guides`, or"
    " fewer"
)
_reel_of_sensor = _says("actuator '{a}' belongs on the sheath's instance, not on a sensor's")
_second_reel = _says("a sheath has one reel, and actuator '{a}' is another")
_other_reel = _says("reel '{a}' acts on tendon '{b}', the sheath on '{c}'")
_other_object = _says(
    "sensor '{a}' is on tendon '{b}', its instance on '{c}', which `attach` cannot have renamed so"
)
_no_object = _says(
    "sensor '{a}' has no tendon as its object: give it objtype=\"tendon\" and the tendon's name as"
    " objname"
)
_renamed = _says(
    "sensor '{a}' has no object, and by '{b}' the attribute tendon may mean tendon '{c}' since"
    ' `attach`: give the sensor objtype="tendon" and the tendon\'s name as objname'
)
_several_joints = _says(
    "{name} = '{value}' may mean two joints, as the name of tendon '{a}' holds more than once what"
    " the attribute tendon is; rename one of the joints"
)
_other_width = _says(
    "sensor '{a}' shows a number per guide, and has not as many as tendon '{b}' has guides: give"
    " its instance the attribute guides of that tendon's sheath"
)
_no_stiffness = _says(
    "{name} is missing (its unit is N); only a tendon that an actuator, a spring of its own, an"
    " equality or a limit pulls on does without"
)
_no_cable = _says(
    "spring = cable, and tendon '{value}' has the stiffness {a} {b} {c}; a cable's stiffness is"
    " positive and linear from one rest length on: give it such ones, or axial_stiffness [N]"
)
_given = _says(
    "{name} = {value} " + GIVEN.format("'{a}'") + "; remove it, or wind the tendon in by a reel or"
    " a reel_joint"
)
_no_actuator = _says(
    "tendon '{value}' is a fixed tendon, and no actuator acts on it, or on its one joint: give an"
    " actuator a cable by tendon_mj.add_cable_drive"
)
_no_drum = _says(
    "tendon '{value}' is fixed, with radius = '{a}' and inner_guides = '{b}': give its drum's"
    " radius [m], and inner_guides = 1 for the bend of its cable, extra_bend [rad]"
)
_not_drawn = _says("{name} = {value} " + NOT_DRAWN.format("'{a}'") + "; remove it")
_drawn = _says(f"{{name}} = {{value}} {DRAWN}; remove it")
_branches = _says(
    "tendon '{value}' branches at a pulley, which only a tendon that an actuator pulls on may; give"
    " each branch a tendon of its own"
)
_no_branch = _says("tendon '{value}' has a pulley without a branch before and behind it")
_input_of_branches = _says(
    "tendon '{value}' branches at a pulley, behind its site '{a}', and every branch has its input"
    " where it begins: leave out input_end = last and draw each branch from its input on, or give"
    " each a tendon of its own"
)
_own_spring = _says(
    "tendon '{value}' has a stiffness of its own, {a} {b} {c}, which would act besides the sheath's"
    " axial_stiffness; remove it, or write spring = cable"
)
_past_reel = _says(
    "actuator '{a}' pulls on tendon '{value}' as a whole, past the reel that winds it; remove one"
    " of them"
)
_past_cable = _says(
    "spring = cable, and actuator '{a}' pulls on tendon '{value}' as a whole; write spring = input,"
    " so that both forces are its input tension"
)
_other_count = _says(
    "{name} = {value}, but tendon '{a}' runs over {b} between its ends; remove the attribute or"
    " correct it"
)
_too_few = _says(
    "the model keeps {a} numbers of its state, and this release of tendon-mj needs {b}: compile it"
    " from its MJCF again"
)
_only_arcs = _says(
    "{name} = {value} is shared by guides at sites, as the tendon may leave a geom, and tendon"
    " '{a}' has none: give inner_guides"
)
_no_arc_guides = _says(
    "tendon '{value}' wraps around geoms: beside guides, arc_guides has to be given too, the number"
    " of guides on each of them"
)
_does_not_fit = _says("{name} = {value} is too few for the path of the tendon")
_too_many = _says("{name} = {value} [s] is more than {a} samples to remember")
_shared_servo = _says("{a} actuators share it; a servo drives one motor")
_other_joint = _says("unknown sheathed tendon '{a}' with the reel_joint '{b}'")
_no_joint = _says("actuator '{a}' drives no joint, but a servo drives a sheath's reel_joint")
_geared = _says(
    "actuator '{a}' has gear = {b}; it must be 1, a gear belongs into motor_inertia and the gains"
)
_limited = _says(
    "actuator '{a}' has a forcerange, which would also limit what the gear holds; use torque_limit"
)
_second_servo = _says("tendon '{value}' already has servo '{a}'; a motor has one")
_no_inertia = _says("{name} [kg m²] is missing, and joint '{a}' has no armature to take its place")
_swings_up = _says(
    "{name} = {value} [N m s/rad] makes the motor swing up instead of damping it: with its period"
    " and delay, a time step of {c} s and motor_inertia = {b} kg m² it must be < {a}"
)
_other_slots = _says(
    "the binary model is of a program with another plugin in this slot: load its MJCF instead, or"
    " first the same plugins in the same order"
)


@compiled
def _row(rows: NDArray[np.uint8], k: int) -> int:
    """Address of a row of text."""
    return rows[k].ctypes.data


@compiled
def _is_servo(m: Model, instance: int) -> bool:
    return at.index_of(plugin_name(m, instance), _PLUGINS) == 1


@apart
def _name_of(m: Model, kind: int, index: int) -> int:
    """Address of the name of an element, of an empty text if it has none."""
    name = mj_id2name(m, kind, index)
    return _none() if name == 0 else name


@apart
def _value_of(m: Model, instance: int, attribute: int) -> int:
    """Address of an attribute's value, of a tendon's its name as `attach` has changed it."""
    if attribute == at.TENDON and not _is_servo(m, instance):
        tendon = names.tendon_of(m, instance)
        if tendon >= 0:
            return _name_of(m, names.TENDON, tendon)
    return at.text_at(m, instance, attribute)


@compiled
def has_refused(out: int) -> bool:
    """Return whether there is a message at an address."""
    return letters(out)[0] != 0


@apart
def _say(
    m: Model, out: int, instance: int, attribute: int, text: int, a: int = 0, b: int = 0, c: int = 0
) -> int:
    """Write a sentence about an attribute, −1 for none, behind its place, unless one is there.

    Returns:
        Bytes of the message.
    """
    if has_refused(out):
        return 0
    used = append(out, append(out, 0, _plugin(), _HALF), plugin_name(m, instance), _HALF)
    own = names.own_name(m, instance)
    if own != 0:
        used = append(out, append(out, used, _instance(), _HALF), own, _HALF // 2)
        used = append(out, used, _quote(), _HALF)
    used = append(out, used, _colon(), _HALF)
    letter, index = letters(text)[0], 0
    while letter != 0:
        part = 0
        if letter == 1:
            part = _row(_SHEATH_NAMES, attribute)
            if _is_servo(m, instance):
                part = _row(_SERVO_NAMES, attribute)
        elif letter == 2:
            part = _value_of(m, instance, attribute)
        elif letter <= 5:
            part = a if letter == 3 else (b if letter == 4 else c)
        elif used < _SIZE - 1:
            letters(out)[used] = letter
            used += 1
        if part != 0:
            used = append(out, used, part, min(used + _HALF // 4, _SIZE - 1))
        index += 1
        letter = letters(text)[index]
    letters(out)[used] = 0
    return used


@apart
def _say_unknown(
    m: Model, out: int, instance: int, attribute: int, which: int, text: int, name: int, b: int = 0
) -> None:
    """Refuse a name, and let Python list those that may be meant."""
    used = _say(m, out, instance, attribute, text, name, b)
    if 0 < used <= _HALF and word(_advice()) != 0:
        _ask(word(_advice()), out + used, m, which, name)


@apart
def check_more(m: Model, out: int, instance: int) -> None:
    """Let Python check what compiled code does not, if there is Python."""
    if not has_refused(out) and word(_advice()) != 0:
        letters(out)[append(out, 0, _interrupted(), _SIZE)] = 0  # which Python replaces
        _ask(word(_advice()), out, m, MORE, instance)


@apart
def refuse(out: int, d: Data, instance: int) -> None:
    """Raise the message of `init` in MuJoCo, if there is one, and delete the data."""
    if has_refused(out):
        d.nplugin = instance  # only those before it have begun
        mj_deleteData(d)
        mju_error(out)


@apart
def refuse_slot(m: Model, instance: int) -> None:
    """Refuse an instance in the slot of a placeholder, before there are data."""
    out = message()
    letters(out)[0] = 0
    _say(m, out, instance, -1, _other_slots())
    mju_error(out)


@apart
def refuse_slot_of_data(m: Model, d: Data, instance: int) -> None:
    """Refuse an instance in the slot of a placeholder."""
    out = message()
    letters(out)[0] = 0
    _say(m, out, instance, -1, _other_slots())
    refuse(out, d, instance)


@compiled
def _written(number: float, digits: int, place: int) -> int:
    """Address of a number as text, at ``place``."""
    return _gcvt(number, digits, place)


@apart
def _is_number(text: int) -> bool:
    """Return whether a text that is not empty is a number, which C and Python read alike."""
    k = 0
    while letters(text)[k] != 0:
        if letters(text)[k] <= 32 or letters(text)[k] in (40, 88, 120):  # space, (, X, x
            return False
        k += 1
    end = _end()
    read_number(text, end)
    return word(end) == text + k


@apart
def _check_number(
    m: Model,
    out: int,
    instance: int,
    attribute: int,
    limits: FloatArray,
    texts: tuple[int, int, int],
) -> None:
    """Refuse a number that is missing, not a number, or out of range."""
    text, (outside, extreme, missing) = at.text_at(m, instance, attribute), texts
    if letters(text)[0] == 0:
        if letters(missing)[0] != 0:
            _say(m, out, instance, attribute, missing)
        return
    if not _is_number(text):
        _say(m, out, instance, attribute, _no_number())
    value, low = at.number_at(text), limits[0]
    above = value > low or (limits[1] != 0.0 and value == low)
    if not (math.isfinite(value) and above and value < limits[2]):
        _say(m, out, instance, attribute, outside)
    if not limits[3] <= abs(value) <= LARGEST:
        _say(m, out, instance, attribute, extreme)


@apart
def _check_word(
    m: Model, out: int, instance: int, attribute: int, known: NDArray[np.uint8], which: int
) -> None:
    text = at.text_at(m, instance, attribute)
    if letters(text)[0] != 0 and at.index_of(text, known) < 0:
        _say_unknown(m, out, instance, attribute, which, _unknown_word(), text)


_BAD_COUNT = -2


@apart
def _count(m: Model, instance: int, attribute: int, otherwise: int) -> int:
    """A count that an attribute of a sheath states; `_BAD_COUNT` if it is not a count."""
    text, count, digits = at.text_at(m, instance, attribute), 0, 0
    while 48 <= letters(text)[digits] <= 57 and digits < 7:
        count = 10 * count + letters(text)[digits] - 48
        digits += 1
    if letters(text)[0] == 0:
        return otherwise
    return count if digits <= 6 and letters(text)[digits] == 0 else _BAD_COUNT


@apart
def _sheath_on(m: Model, tendon: int, but: int) -> int:
    """First sheath on a tendon that is another than ``but``, −1 for none."""
    for other in range(m.nplugin if tendon >= 0 else 0):
        if other == but or at.index_of(plugin_name(m, other), _PLUGINS) != 0:
            continue
        if not at.is_sensor(m, other) and names.tendon_of(m, other) == tendon:
            return other
    return -1


@apart
def sheath_state(m: Model, out: int, instance: int) -> int:
    """Check the attributes of a sheath or sensor; numbers of its state, 0 if they are refused."""
    _check_word(m, out, instance, at.SENSOR, at.KIND_NAMES, KINDS)
    if at.is_sensor(m, instance):
        _check_sensor(m, out, instance)
        return 0 if has_refused(out) else 1
    for k in range(len(_LAW_RANGES)):
        texts = _row(_LAW_OUTSIDE, k), _row(_LAW_EXTREME, k), _row(_LAW_MISSING, k)
        _check_number(m, out, instance, at.FIRST_PARAMETER + k, _LAW_RANGES[k], texts)
    _check_scales(m, out, instance)
    _check_spool(m, out, instance, at.REEL_JOINT, _REEL_RADIUS, _REEL_PLAY)
    _check_spool(m, out, instance, at.OUTPUT_JOINT, _OUTPUT_RADIUS, _OUTPUT_PLAY)
    _check_word(m, out, instance, at.INPUT_END, at.END_NAMES, ENDS)
    _check_word(m, out, instance, at.SPRING, at.SPRING_NAMES, SPRINGS)
    numbers = _check_size(m, out, instance)
    return 0 if has_refused(out) else numbers


@apart
def _check_sensor(m: Model, out: int, instance: int) -> None:
    """Refuse attributes of a sheath, and a number of guides that is missing."""
    for attribute in range(len(_SHEATH_NAMES)):
        is_own = attribute in (at.SENSOR, at.TENDON, at.GUIDES, at.INSTANCE)
        if not is_own and at.is_given(m, instance, attribute):
            _say(m, out, instance, attribute, _not_of_a_sensor())
    if _guides_of_sensor(m, instance) < 0:
        tendon, kind = at.text_at(m, instance, at.TENDON), at.text_at(m, instance, at.SENSOR)
        _say_unknown(m, out, instance, at.GUIDES, SHEATHED, _unsized(), tendon, kind)


@apart
def _guides_of_sensor(m: Model, instance: int) -> int:
    """Guides that the sensors of an instance show, below 0 if it does not say.

    Without `guides` they are those of the sheath with the same `tendon`, the nearest before it: the
    names may be those of several models that are attached.
    """
    if at.numbers_of(at.sensor_kind(m, instance), 2) == 1:
        return 0
    guides, written = _count(m, instance, at.GUIDES, -1), at.text_at(m, instance, at.TENDON)
    for step in range(1, m.nplugin if guides == -1 else 0):
        other = (instance - step + m.nplugin) % m.nplugin
        if not at.is_sheath(m, other, instance):
            continue
        if names.is_same(at.text_at(m, other, at.TENDON), written):
            return min(_capacity(m, other)[0], _MOST_STATE)
    return guides


@apart
def _check_scales(m: Model, out: int, instance: int) -> None:
    """Refuse μ_s < μ_d, and an effect without the parameter that scales it."""
    friction, static = at.number(m, instance, _FRICTION), at.number(m, instance, _STATIC)
    if at.is_given(m, instance, _STATIC) and static < friction:
        text = at.text_at(m, instance, _FRICTION)
        _say(m, out, instance, _STATIC, _slips(), text)
    for k in range(len(_SCALES)):
        attribute = at.FIRST_PARAMETER + k
        scale = at.FIRST_PARAMETER + max(_SCALES[k], 0)
        is_scaled = _SCALES[k] < 0 or at.number(m, instance, scale) > 0.0
        if at.number(m, instance, attribute) > 0.0 and not is_scaled:
            _say(m, out, instance, attribute, _row(_UNSCALED, k))


@apart
def _check_spool(m: Model, out: int, instance: int, joint: int, radius: int, play: int) -> None:
    """Refuse a joint of a spool without a radius, a radius or play without a joint."""
    if at.number(m, instance, play) > 0.0 and not at.is_given(m, instance, joint):
        _say(m, out, instance, play, _together(), _row(_SHEATH_NAMES, joint))
    has_joint, has_radius = at.is_given(m, instance, joint), at.is_given(m, instance, radius)
    if has_joint != has_radius:
        _say(m, out, instance, joint, _together(), _row(_SHEATH_NAMES, radius))
    if has_radius and at.number(m, instance, radius) == 0.0:
        _say(m, out, instance, radius, _no_radius())
    if has_joint and not at.is_given(m, instance, at.TENDON):
        _say(m, out, instance, joint, _together(), _row(_SHEATH_NAMES, at.TENDON))


@apart
def _capacity(m: Model, instance: int) -> tuple[int, int]:
    """Guides and arcs of a sheath to allocate memory for; a bad count is as one not given."""
    guides = max(NOT_GIVEN, _count(m, instance, at.GUIDES, NOT_GIVEN))
    each = _count(m, instance, at.ARC_GUIDES, NOT_GIVEN)
    inner = max(0, _count(m, instance, at.INNER_GUIDES, 0))
    return capacity(m, guides, each if each > 0 else NOT_GIVEN, inner)


@apart
def _state_size(m: Model, instance: int) -> int:
    """Numbers of state of a sheath."""
    guides, arcs = _capacity(m, instance)
    leads = at.first_sheath(m, instance) == instance
    return size_of(guides, arcs, m.nv if leads else 0)


@apart
def _check_size(m: Model, out: int, instance: int) -> int:
    """Refuse bad counts, and sheaths that would fill memory; numbers of state."""
    for attribute in (at.ARC_GUIDES, at.GUIDES, at.INNER_GUIDES):
        if _count(m, instance, attribute, 1) == _BAD_COUNT:
            _say(m, out, instance, attribute, _no_count())
    if _count(m, instance, at.ARC_GUIDES, 1) == 0:
        _say(m, out, instance, at.ARC_GUIDES, _no_arc())
    if at.first_sheath(m, instance) == instance:
        total, largest, most = 0, instance, 0
        for other in range(instance, m.nplugin):
            if at.is_sheath(m, other, instance):
                numbers = _state_size(m, other)
                total += numbers
                if numbers > most:
                    largest, most = other, numbers
        if total > _MOST_STATE:
            by_arcs = not at.is_given(m, largest, at.GUIDES)
            by_arcs = by_arcs and at.is_given(m, largest, at.ARC_GUIDES)
            attribute = at.ARC_GUIDES if by_arcs else at.GUIDES
            text = _written(float(total), 15, _digits())
            _say(m, out, largest, attribute, _too_large(), text)
    return min(_state_size(m, instance), _MOST_STATE)


@apart
def check_elements(m: Model, out: int, instance: int) -> None:
    """Refuse actuators and sensors on an instance that are not of its sheath."""
    tendon, reels, sensor = names.tendon_of(m, instance), 0, at.is_sensor(m, instance)
    written = at.text_at(m, instance, at.TENDON)
    for k in range(m.nactuator):
        if m.actuator_plugin[k] == instance:
            name = _name_of(m, _ACTUATOR, k)
            reels += 1
            if sensor:
                _say(m, out, instance, -1, _reel_of_sensor(), name)
            elif reels > 1:
                _say(m, out, instance, -1, _second_reel(), name)
            elif m.actuator_trntype[k] == ON_TENDON:
                other = _name_of(m, names.TENDON, m.actuator_trnid[k, 0])
                if names.place_of(other, written, 0) < 0 or not acts_on(m, k, tendon):
                    _say(m, out, instance, -1, _other_reel(), name, other, written)
    for k in range(m.nsensor):
        if m.sensor_plugin[k] == instance:
            _check_object(m, out, instance, k, tendon)
    if not sensor:
        _check_tendon(m, out, instance, tendon)


@apart
def _check_tendon(m: Model, out: int, instance: int, tendon: int) -> None:
    """Refuse a tendon that is missing or another's, and joints that do not exist or cannot wind."""
    rival, written = _sheath_on(m, tendon, instance), at.text_at(m, instance, at.TENDON)
    if rival >= 0:
        _say(m, out, instance, at.TENDON, _second(), names.own_name(m, rival))
    if tendon < 0:
        _say_unknown(m, out, instance, at.TENDON, TENDONS, _unknown_tendon(), written)
    for joint in (at.REEL_JOINT, at.OUTPUT_JOINT):
        text, index = at.text_at(m, instance, joint), names.joint_of(m, instance, joint)
        if index == names.SEVERAL:
            _say(m, out, instance, joint, _several_joints(), _name_of(m, names.TENDON, tendon))
        elif index < 0 and letters(text)[0] != 0:
            _say_unknown(m, out, instance, joint, JOINTS, _unknown_joint(), text)
        elif index >= 0 and m.jnt_type[index] < _SLIDE:
            _say(m, out, instance, joint, _no_spool())


@apart
def _check_object(m: Model, out: int, instance: int, sensor: int, tendon: int) -> None:
    """Refuse a sensor that shows the sheath of no tendon, or of another."""
    shown, name = names.tendon_of_sensor(m, sensor), _name_of(m, _SENSOR, sensor)
    written, kind = at.text_at(m, instance, at.TENDON), m.sensor_objtype[sensor]
    if kind not in (0, names.TENDON) or (kind == 0 and not at.is_given(m, instance, at.TENDON)):
        _say(m, out, instance, -1, _no_object(), name)
    for k in range(m.ntendon if kind == 0 else 0):
        if k != shown and names.place_of(_name_of(m, names.TENDON, k), written, 0) >= 0:
            _say(m, out, instance, -1, _renamed(), name, written, _name_of(m, names.TENDON, k))
    if shown < 0:
        _say_unknown(m, out, instance, at.TENDON, TENDONS, _unknown_tendon(), written)
        return
    shows, is_sensor = _name_of(m, names.TENDON, shown), at.is_sensor(m, instance)
    if names.place_of(shows, written, 0) < 0:
        _say(m, out, instance, -1, _other_object(), name, shows, written)
    elif not is_sensor and shown != tendon:
        _say(m, out, instance, -1, _other_object(), name, shows, _name_of(m, names.TENDON, tendon))
    if not is_sensor:
        return
    sheath = _sheath_on(m, shown, -1)
    if sheath < 0:
        _say_unknown(m, out, instance, -1, SHEATHED, _unknown_object(), shows, name)
        return
    kind, width = at.sensor_kind(m, instance), m.sensor_dim[sensor]
    fits = width == at.numbers_of(kind, _capacity(m, sheath)[0])
    if not fits and width != at.numbers_of(kind, int(_guides_of(m, sheath, shown)[0])):
        _say(m, out, instance, at.GUIDES, _other_width(), name, shows)


@apart
def _guides_of(m: Model, instance: int, tendon: int) -> tuple[float, float, float]:
    """Guides, arcs and pulleys of a sheath's path; the model is complete."""
    each = _count(m, instance, at.ARC_GUIDES, 1)
    return count_guides(m, tendon, each, _count(m, instance, at.INNER_GUIDES, 0))


@apart
def check_bound(m: Model, out: int, instance: int, bound: Bound) -> None:
    """Refuse a sheath that cannot act on its tendon; the model is complete."""
    tendon = names.tendon_of(m, instance)
    if is_fixed(m, tendon):
        _check_fixed(m, out, instance, tendon)
    else:
        _check_drive(m, out, instance, bound, tendon)
        _check_branches(m, out, instance, bound, tendon)
        _check_pull(m, out, instance, bound, tendon)
    _check_counts(m, out, instance, tendon)
    if bound.tendon < 0.0:
        _say(m, out, instance, at.GUIDES, _does_not_fit())


@apart
def _refuse_given(
    m: Model, out: int, instance: int, attributes: IntArray, text: int, name: int
) -> None:
    """Refuse numbers of attributes that have no meaning, unless they are 0."""
    for k in range(len(attributes)):
        if at.number(m, instance, attributes[k]) != 0.0:
            _say(m, out, instance, attributes[k], text, name)


@apart
def _check_fixed(m: Model, out: int, instance: int, tendon: int) -> None:
    """Refuse a fixed tendon without an actuator, and parameters that its cable cannot have."""
    pullers, name = 0, _name_of(m, names.TENDON, tendon)
    for k in range(m.nactuator):
        pullers += _pulls(m, k, instance, tendon)
    if pullers == 0:
        _say(m, out, instance, at.TENDON, _no_actuator())
    radius, guides = at.number(m, instance, _RADIUS), _count(m, instance, at.INNER_GUIDES, 0)
    if radius == 0.0 or guides != 1:
        given = at.text_at(m, instance, _RADIUS)
        count = at.text_at(m, instance, at.INNER_GUIDES)
        _say(m, out, instance, at.TENDON, _no_drum(), given, count)
    for joint in (at.REEL_JOINT, at.OUTPUT_JOINT):
        if at.is_given(m, instance, joint):
            _say(m, out, instance, joint, _not_drawn(), name)
    if at.is_cable_spring(m, instance):
        _say(m, out, instance, at.SPRING, _not_drawn(), name)
    _refuse_given(m, out, instance, _OF_A_PATH, _not_drawn(), name)


@compiled
def _pulls(m: Model, actuator: int, instance: int, tendon: int) -> bool:
    """Return whether an actuator pulls a tendon as a whole, and is neither reel nor servo."""
    owner = m.actuator_plugin[actuator]
    is_other = owner != instance and (owner < 0 or not _is_servo(m, owner))
    return is_other and acts_on(m, actuator, tendon)


@apart
def _check_drive(m: Model, out: int, instance: int, bound: Bound, tendon: int) -> None:
    """Refuse parameters that do not go with what pulls the tendon."""
    _refuse_given(m, out, instance, _OF_A_DRUM, _drawn(), 0)
    has_stiffness = at.is_given(m, instance, at.AXIAL_STIFFNESS)
    name, is_cable = _name_of(m, names.TENDON, tendon), bound.own_spring != 0.0
    if not (has_stiffness or bound.driven != 0.0 or is_cable):
        _say(m, out, instance, at.AXIAL_STIFFNESS, _no_stiffness())
    if is_cable and not has_stiffness and not _is_linear(m, tendon):
        _say_stiffness(m, out, instance, _no_cable(), tendon)
    if bound.driven != 0.0:
        _refuse_given(m, out, instance, _OF_A_REEL, _given(), name)


@apart
def _say_stiffness(m: Model, out: int, instance: int, text: int, tendon: int) -> None:
    """Refuse a tendon by the coefficients of its stiffness."""
    higher = m.tendon_stiffnesspoly[tendon]
    linear = _written(m.tendon_stiffness[tendon], 6, _digits())
    second, third = _written(higher[0], 6, _digits()), _written(higher[1], 6, _digits())
    _say(m, out, instance, at.TENDON, text, linear, second, third)


@apart
def _is_linear(m: Model, tendon: int) -> bool:
    """Return whether a tendon's own spring is positive and linear from one rest length on."""
    higher, lengths = m.tendon_stiffnesspoly[tendon], m.tendon_lengthspring[tendon]
    is_plain = m.tendon_stiffness[tendon] > 0.0 and higher[0] == 0.0 and higher[1] == 0.0
    return is_plain and lengths[1] > 0.0 and not 0.0 < lengths[0] < lengths[1]


@apart
def _check_branches(m: Model, out: int, instance: int, bound: Bound, tendon: int) -> None:
    """Refuse pulleys where they cannot be."""
    if bound.pulleys == 0.0:
        return
    if bound.driven == 0.0:
        _say(m, out, instance, at.TENDON, _branches())
    kinds, first = m.wrap_type, m.tendon_adr[tendon]
    last = first + m.tendon_num[tendon] - 1
    pulley = last
    for k in range(last, first - 1, -1):
        if kinds[k] == PULLEY:
            pulley = k
            if k in (first, last) or kinds[k + 1] == PULLEY:
                _say(m, out, instance, at.TENDON, _no_branch())
    if bound.input_at_last != 0.0:
        site = _name_of(m, _SITE, m.wrap_objid[pulley - 1])
        _say(m, out, instance, at.TENDON, _input_of_branches(), site)


@apart
def _check_pull(m: Model, out: int, instance: int, bound: Bound, tendon: int) -> None:
    """Refuse a tendon that is pulled in two ways."""
    is_cable = bound.own_spring != 0.0
    if is_wound(bound) and has_spring(m, tendon) and not is_cable:
        _say_stiffness(m, out, instance, _own_spring(), tendon)
    for k in range(m.nactuator):
        if _pulls(m, k, instance, tendon):
            if is_wound(bound):
                _say(m, out, instance, at.TENDON, _past_reel(), _name_of(m, _ACTUATOR, k))
            elif is_cable:
                _say(m, out, instance, at.TENDON, _past_cable(), _name_of(m, _ACTUATOR, k))


@apart
def _check_counts(m: Model, out: int, instance: int, tendon: int) -> None:
    """Refuse counts that are not those of the path, or that another release stored."""
    stored, needed = m.plugin_statenum[instance], _state_size(m, instance)
    if stored < needed:
        text = _written(float(stored), 15, _digits())
        _say(m, out, instance, at.GUIDES, _too_few(), text, _written(float(needed), 15, _digits()))
    guides, arcs, pulleys = _guides_of(m, instance, tendon)
    each = _count(m, instance, at.ARC_GUIDES, 1)
    name, has_guides = _name_of(m, names.TENDON, tendon), at.is_given(m, instance, at.GUIDES)
    if has_guides and _count(m, instance, at.GUIDES, 0) != guides:
        text = _written(float(guides), 15, _digits())
        _say(m, out, instance, at.GUIDES, _other_count(), name, text)
    if arcs > 0 and guides == arcs * each + pulleys:
        _refuse_given(m, out, instance, _UNDRAWN, _only_arcs(), name)
    if arcs > 0 and has_guides and not at.is_given(m, instance, at.ARC_GUIDES):
        _say(m, out, instance, at.TENDON, _no_arc_guides())


@apart
def sensor_width(m: Model, instance: int) -> int:
    """Numbers of a sensor on an instance; 1 for what is refused."""
    if not at.is_sensor(m, instance):
        return at.ENDS
    return max(1, at.numbers_of(at.sensor_kind(m, instance), _guides_of_sensor(m, instance)))


@apart
def servo_state(m: Model, out: int, instance: int) -> int:
    """Check the attributes of a servo; numbers of its state, 0 if they are refused."""
    for k in range(len(_GAIN_RANGES)):
        texts = _row(_GAIN_OUTSIDE, k), _row(_GAIN_EXTREME, k), _row(_GAIN_MISSING, k)
        _check_number(m, out, instance, k, _GAIN_RANGES[k], texts)
    _check_word(m, out, instance, sv.FEEDBACK, _FEEDBACKS, FEEDBACKS)
    _check_word(m, out, instance, sv.BACKDRIVE, _SWITCH, SWITCH)
    if has_refused(out):
        return 0
    period, delay = at.number(m, instance, _PERIOD), at.number(m, instance, _DELAY)
    commands = sv.capacity(period, delay, m.opt.timestep)
    if commands > sv.MOST_COMMANDS:
        _say(
            m, out, instance, _DELAY, _too_many(), _written(float(sv.MOST_COMMANDS), 15, _digits())
        )
        return 0
    return sv.size_of(commands)


@apart
def check_motor(m: Model, out: int, instance: int) -> None:
    """Refuse a servo that does not drive its tendon's motor, or not alone."""
    count, sheath = 0, names.sheath_wound_by(m, instance, sv.TENDON)
    for k in range(m.nactuator):
        owner = m.actuator_plugin[k]
        if owner == instance:
            count += 1
            _check_actuator(m, out, instance, k, sheath)
        elif sheath < 0 or owner < 0 or not _is_servo(m, owner):
            continue
        elif names.sheath_wound_by(m, owner, sv.TENDON) == sheath:
            _say(m, out, instance, sv.TENDON, _second_servo(), names.own_name(m, owner))
    if count > 1:
        _say(m, out, instance, -1, _shared_servo(), _written(float(count), 15, _digits()))
    joint = names.joint_of(m, sheath, at.REEL_JOINT) if sheath >= 0 else -1
    if joint < 0:
        return  # which the sheath refuses
    armature = m.dof_armature[m.jnt_dofadr[joint]]
    has_inertia = at.is_given(m, instance, _INERTIA)
    if not has_inertia and not armature > 0.0:
        _say(m, out, instance, _INERTIA, _no_inertia(), _name_of(m, _JOINT, joint))
    _check_damping(m, out, instance, at.number(m, instance, _INERTIA) if has_inertia else armature)


@apart
def _check_actuator(m: Model, out: int, instance: int, actuator: int, sheath: int) -> None:
    name, joint = _name_of(m, _ACTUATOR, actuator), names.motor_of(m, actuator)
    if joint < 0:
        _say(m, out, instance, -1, _no_joint(), name)
    elif sheath < 0:
        tendon, driven = at.text_at(m, instance, sv.TENDON), _name_of(m, _JOINT, joint)
        _say_unknown(m, out, instance, -1, SHEATHED, _other_joint(), tendon, driven)
    gear = m.actuator_gear[m.actuator_outadr[actuator], 0]
    if gear != 1.0:
        _say(m, out, instance, -1, _geared(), name, _written(gear, 6, _digits()))
    if m.actuator_forcelimited[actuator]:
        _say(m, out, instance, -1, _limited(), name)


@apart
def _check_damping(m: Model, out: int, instance: int, inertia: float) -> None:
    """Damping that is not taken implicitly has a largest value."""
    period, delay = at.number(m, instance, _PERIOD), at.number(m, instance, _DELAY)
    most = inertia * largest_damping(m.opt.timestep, m.opt.integrator, period, delay)
    for k in range(len(_DAMPINGS)):
        if at.number(m, instance, _DAMPINGS[k]) >= most:
            limit, mass = _written(most, 3, _digits()), _written(inertia, 6, _digits())
            step = _written(m.opt.timestep, 6, _digits())
            _say(m, out, instance, _DAMPINGS[k], _swings_up(), limit, mass, step)


@apart
def largest_damping(timestep: float, integrator: int, period: float, delay: float) -> float:
    """Rate G_v/J [1/s] from which on damping makes the motor swing up instead; may be without end.

    Args:
        timestep: [s].
        integrator: MuJoCo's number of it.
        period: between samples of the controller [s]; 0: every time step.
        delay: from a sample to its torque [s].
    """
    if period > 0.0 or delay > 0.0:  # a torque changes on time steps only
        return _sampled_damping(
            max(period, timestep), math.ceil(delay / timestep - 1e-6) * timestep
        )
    return _RUNGE_KUTTA / timestep if integrator == RK4 else math.inf


@apart
def _sampled_damping(held: float, delay: float) -> float:
    """Like ``largest_damping`` where every torque is held for a while [1/s].

    v_{k+1} = v_k − g ((1 − m) v_{k−d} + m v_{k−d−1}) with g = held G_v/J and delay = (d + m) held:
    the least g for which a root lies on the unit circle, z = e^{iω}. That is 2/held without a delay
    and tends to π/(2 delay) with a long one.
    """
    whole = math.floor(delay / held + 1e-9)
    part = max(delay / held - whole, 0.0)
    low, high = 0.0, math.pi
    for _ in range(60):
        middle = 0.5 * (low + high)
        late = math.atan2(part * math.sin(middle), 1.0 - part + part * math.cos(middle))
        if (whole + 0.5) * middle + late >= 0.5 * math.pi:
            high = middle
        else:
            low = middle
    across, along = part * math.sin(high), 1.0 - part + part * math.cos(high)
    return 2.0 * math.sin(0.5 * high) / (math.sqrt(across * across + along * along) * held)
