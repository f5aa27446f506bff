"""Refusals when a model is compiled; each message has the place, the value and a remedy."""

import contextlib
import ctypes
import gc
import sys
from itertools import starmap

import mujoco
import numpy as np
import pytest

from tendon_mj import add_friction
from tendon_mj.plugin import PARAMETERS
from tendon_mj.plugin.compiled_checks import OF_A_REEL
from tests.plugin.test_servo_refusals import compiled as servo
from tests.refusals import refusing
from tests.rigs import instance, rope, shown, simulated, spatial, unpacked

HAND = """
<mujoco>
  <extension><plugin plugin="tendon_mj.sheath">{instances}</plugin></extension>
  <worldbody>
    <site name="a"/><site name="g" pos=".2 0 0"/><site name="b" pos=".3 .2 0"/>
    <geom name="peg" type="cylinder" size=".02 .1" pos=".1 .1 0" contype="0" conaffinity="0"/>
    <body name="link"><joint name="knuckle"/><geom size=".1" contype="0" conaffinity="0"/></body>
    <body name="ball"><joint name="socket" type="ball"/><geom size=".1" contype="0"/></body>
    <body name="loose"><freejoint name="loose"/><geom size=".1" contype="0"/></body>
  </worldbody>
  <tendon>{tendons}<fixed name="coupling"><joint joint="knuckle" coef="1"/></fixed></tendon>
  <actuator>{actuators}</actuator>
  <sensor>{sensors}</sensor>
</mujoco>
"""
PATHS = {"flexor": "a g b", "extensor": "a b", "wrapped": "a peg@ b", "forked": "a g /2 g b"}
TENDONS = "".join(starmap(spatial, PATHS.items())) + spatial("stiff", "a b", 'stiffness="40"')
LAW = {"tendon": "flexor", "axial_stiffness": "1000", "friction": "0.1"}


def hand(*instances, sensors="", actuators=""):
    parts = {"tendons": TENDONS, "sensors": sensors, "actuators": actuators}
    return HAND.format(instances="".join(instances), **parts)


def compiled(*instances, **more):
    return mujoco.MjModel.from_xml_string(hand(*instances, **more))


WRAPPED = {"tendon": "wrapped", "arc_guides": "2"}
KNUCKLE = {"reel_joint": "knuckle", "reel_radius": "0.01"}
WHERE = "plugin tendon_mj.sheath instance 'bad': "
CASES = [
    ({"tendon": "flexer"}, "unknown tendon 'flexer'"),
    ({"tendon": None}, "unknown tendon ''"),
    ({"friction": "-0.1"}, "friction = -0.1 [-]", "≥ 0"),
    ({"friction": "nan"}, "friction = nan [-]"),
    ({"friction": "inf"}, "friction = inf [-]"),
    ({"friction": "1e999"}, "friction = 1e999 [-]"),
    ({"pretension": "1e308"}, "pretension = 1e308 [N]", "0 to 1e+30"),
    ({"axial_stiffness": "1e-320"}, "axial_stiffness = ", "1e-30 to 1e+30"),
    ({"friction": "low"}, "friction = 'low'"),
    ({"friction": "0.1 0.2"}, "friction = '0.1 0.2'"),
    ({"friction": None}, "friction is missing"),
    ({"axial_stiffness": "0"}, "axial_stiffness = 0 [N]", "> 0"),
    ({"axial_stiffness": "-5"}, "axial_stiffness = -5 [N]", "> 0"),
    ({"axial_stiffness": None}, "axial_stiffness is missing", "unit is N"),
    ({"pretension": "-1"}, "pretension = -1 [N]", "≥ 0"),
    ({"constant_friction": "-1"}, "constant_friction = -1 [N]", "≥ 0"),
    ({"axial_damping": "inf"}, "axial_damping = inf [N s]", "≥ 0"),
    ({"static_friction": "0.05"}, "static_friction = 0.05", "friction = 0.1"),
    ({"direction_asymmetry": "1"}, "direction_asymmetry = 1 [-]", "> -1 and < 1"),
    ({"backlash": "-1e-3"}, "backlash = -1e-3 [m]", "≥ 0"),
    ({"friction_drift": "nan"}, "friction_drift = nan [1/s]"),
    ({"stribeck_friction": "0.1"}, "stribeck_friction = 0.1", "stribeck_velocity > 0 [m/s]"),
    ({"creep": "0.1", "creep_time": "0"}, "creep = 0.1", "creep_time > 0 [s]"),
    ({"tendon": "coupling"}, "tendon 'coupling'", "fixed tendon"),
    ({"radius": "0.01"}, "radius = 0.01", "a tendon that is drawn"),
    ({"tendon": "wrapped", "guides": "1"}, "'wrapped'", "arc_guides"),
    *(
        (WRAPPED | {undrawn: "1"}, f"{undrawn} = 1", "inner_guides")
        for undrawn in ("extra_bend", "constant_friction")
    ),
    ({"arc_guides": "0"}, "arc_guides = 0"),
    ({"inner_guides": "some"}, "inner_guides = 'some'"),
    ({"arc_guides": "894783", "inner_guides": "154"}, "arc_guides = 894783", "16777216"),
    ({"guides": "999999"}, "guides = 999999", "16777216"),
    ({"tendon": "forked"}, "tendon 'forked'", "pulley"),
    ({"tendon": "stiff", **KNUCKLE}, "tendon 'stiff'", "40 0 0"),
    ({"tendon": "stiff", "pretension": "3"}, "pretension = 3", "'stiff'"),
    ({"reel_joint": "knuckle"}, "reel_joint and reel_radius"),
    ({"reel_radius": "0.01"}, "reel_joint and reel_radius"),
    ({"output_joint": "knuckle"}, "output_joint and output_radius"),
    ({"output_play": "0.1"}, "output_play and output_joint"),
    ({"reel_joint": "knukle", "reel_radius": "0.01"}, "reel_joint: ", "'knukle'"),
    ({"reel_joint": "socket", "reel_radius": "0.01"}, "reel_joint 'socket'", "hinge or slide"),
    ({"output_joint": "loose", "output_radius": "1"}, "output_joint 'loose'", "hinge or slide"),
    ({"reel_joint": "knuckle", "reel_radius": "0"}, "reel_radius = 0 [m]"),
    ({"input_end": "middle"}, "input_end 'middle'"),
    ({"spring": "rubber"}, "spring 'rubber'"),
    ({"spring": "cable", "axial_stiffness": None}, "spring = cable", "'flexor'", "0 0 0"),
    ({"guides": "3"}, "guides = 3", "'flexor' runs over 1"),
    ({"guides": "0"}, "guides = 0", "'flexor' runs over 1"),
    ({"guides": "-1"}, "guides = '-1'"),
    ({"guides": "many"}, "guides = 'many'"),
    # text that C and Python read differently
    ({"axial_stiffness": "1_000"}, "axial_stiffness = '1_000'"),
    ({"friction": "0x1p-3"}, "friction = '0x1p-3'"),
    ({"tendon": "%s%n%d"}, "unknown tendon '%s%n%d'"),
]


REEL = '<plugin name="r" plugin="tendon_mj.sheath" instance="bad" tendon="extensor"/>'
SHOWN = {"sensors": shown("bad")}
SOUND = instance("sheath", **LAW)
MOTOR = {"actuators": '<motor name="pull" tendon="flexor"/>'}
FLEXOR_REEL = REEL.replace("extensor", "flexor")
REFUSED = [
    *((instance("bad", **LAW | values), {}, [WHERE, *facts]) for values, *facts in CASES),
    (SOUND + instance("b", **LAW), {}, ["'flexor'", "a tendon has one sheath"]),
    (instance("bad", **LAW), {"actuators": REEL}, [WHERE, "'r'", "'extensor'", "'flexor'"]),
    (
        instance("bad", **LAW),
        {"actuators": FLEXOR_REEL + FLEXOR_REEL.replace('"r"', '"q"')},
        [WHERE, "one reel", "'q'"],
    ),
    (instance("bad", **LAW, **KNUCKLE), MOTOR, [WHERE, "'pull'", "'flexor'"]),
    *(
        (instance("bad", **LAW, **{name: "0.5"}), MOTOR, [WHERE, f"{name} = 0.5", "'flexor'"])
        for name in OF_A_REEL
    ),
    (
        instance("bad", **LAW | {"tendon": "stiff", "spring": "cable"}),
        {"actuators": '<motor name="pull" tendon="stiff"/>'},
        [WHERE, "'pull'", "'stiff'", "spring"],
    ),
    (
        instance("bad", **LAW | {"tendon": "forked", "input_end": "last"}),
        {"actuators": '<motor name="pull" tendon="forked"/>'},
        [WHERE, "'forked'", "'g'", "input_end"],
    ),
    *(
        (SOUND + instance("bad", **values), SHOWN, [WHERE, *facts])
        for values, *facts in (
            ({"tendon": "flexor", "sensor": "tensoin"}, "sensor 'tensoin'"),
            ({"tendon": "flexor", "sensor": "slip", "friction": "1"}, "takes no friction"),
            ({"tendon": "extensor", "sensor": "slip"}, "'extensor'"),
            ({"tendon": "flexr", "sensor": "slip"}, "guides is missing", "'flexr'"),
        )
    ),
    (
        SOUND + instance("bad", tendon="flexor", sensor="slip"),
        SHOWN | {"actuators": FLEXOR_REEL},
        [WHERE, "'r'", "sensor"],
    ),
]


@pytest.mark.parametrize(
    ("instances", "more", "facts"),
    [*REFUSED, (instance("bad", **LAW, frictoin="0.1"), {}, ["attribute", "frictoin"])],
    ids=str,
)
def test_a_bad_configuration_is_named_with_its_place_and_value(instances, more, facts):
    with refusing(ValueError, *facts):
        compiled(instances, **more)
    # the process and the plugin are as good as before
    data = simulated(compiled(instance("sound", **LAW)), 1)
    assert np.isfinite(data.plugin_state).all()


def keyword(name, text):
    """A value that an attribute states, as an argument of `add_friction`."""
    try:
        return float(text) if name in PARAMETERS else int(text)
    except ValueError:
        return text


IN_PYTHON = [  # `add_friction` counts guides and designs what pulls other tendons than these
    ({name: keyword(name, text) for name, text in values.items()}, facts[0].partition(" = ")[0])
    for values, *facts in CASES
    if "guides" not in values and not {None, "1_000", "154"} & set(values.values())
    if values.get("tendon", "flexor") not in ("stiff", "forked", "wrapped")
]


@pytest.mark.parametrize(("values", "thing"), IN_PYTHON, ids=str)
def test_add_friction_refuses_the_same_or_compiling_its_spec_does(values, thing):
    law = {"tendon": "flexor", "axial_stiffness": 1e3, "friction": 0.1, "pretension": 1.0}
    with refusing(ValueError, thing):
        add_friction(mujoco.MjSpec.from_string(hand()), **law | values).compile()


def test_a_sheath_without_guides_is_no_mistake():
    model = compiled(instance("straight", **(LAW | {"tendon": "extensor", "guides": "0"})))
    scalars, segments, _ = unpacked(model, simulated(model, 1), "straight")
    assert (len(segments), scalars.unsolved) == (1, 0.0)


class Heap(ctypes.Structure):
    """`struct mallinfo2` of glibc: ten numbers, of bytes mapped by themselves and in use."""

    _fields_ = (("numbers", ctypes.c_size_t * 10),)


# The first and last instance of a model are MuJoCo's own: one has begun when ours is refused.
PID = """</plugin><plugin plugin="mujoco.pid"><instance name="p"><config key="kp" value="1"/>
  </instance></plugin><plugin plugin="tendon_mj.sheath">"""
DRIVEN = """<plugin plugin="mujoco.pid" instance="p" joint="knuckle"/>
  <plugin plugin="mujoco.pid" joint="knuckle"><config key="kp" value="1"/></plugin>"""


def spoiled_data():
    """Of a model whose tendon, once compiled, is given what its sheath cannot be on."""
    model = compiled(instance("s", **LAW, **KNUCKLE))
    model.tendon_stiffness[0] = 5.0
    return mujoco.MjData(model)


def bad(**values):
    return instance("bad", **LAW | values)


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="only glibc tells what it holds")
@pytest.mark.parametrize(
    "refusal",
    [
        lambda: compiled(bad(friction="-1")),
        lambda: compiled(instance("good", **LAW), bad(tendon="extensor", guides="x")),
        lambda: compiled(bad(tendon="forked", pretension="1")),
        lambda: compiled(PID, bad(tendon="forked"), actuators=DRIVEN),
        lambda: servo(tension_gain="-1"),
        lambda: servo(target='site="a"'),
        spoiled_data,
    ],
)
def test_a_refusal_leaves_nothing_behind(refusal):
    mallinfo2 = ctypes.CDLL(None).mallinfo2
    mallinfo2.restype = Heap

    def held(times=0):
        for _ in range(times):
            with refusing((ValueError, mujoco.FatalError), "plugin tendon_mj"):
                refusal()
        gc.collect()
        return sum(mallinfo2().numbers[k] for k in (4, 7))

    grown = min(-held() + held(50) for _ in range(3))
    assert grown < 50 * 16  # other things are kept once


def asleep(flag, policy):
    text = rope(
        "a; g .2 0 0",
        "b .3 .2 0",
        body=f'name="link" sleep="{policy}"',
        joint='type="slide" axis="1 0 0" damping="1"',
        geom='size=".1"',
        option='gravity="0 0 0"',
        rest=f'<option><flag sleep="{flag}"/></option>',
        actuator="",
    )
    law = {"friction": 0.1, "axial_stiffness": 1e3, "pretension": 1.0}
    return add_friction(mujoco.MjSpec.from_string(text), "t", **law).compile()


ASLEEP = (ValueError, mujoco.FatalError), "'t'", "'link'", 'sleep="never"'


@pytest.mark.parametrize(
    ("flag", "policy"),
    [
        *(("enable", policy) for policy in ("allowed", "auto", "init", "never")),
        ("disable", "allowed"),
    ],
)
def test_a_body_that_may_fall_asleep_is_refused_with_the_remedy(flag, policy):
    may = flag == "enable" and policy != "never"
    with refusing(*ASLEEP) if may else contextlib.nullcontext():
        data = simulated(asleep(flag, policy), 50)
        assert data.sensor("input_tension").data[0] > 0.0
