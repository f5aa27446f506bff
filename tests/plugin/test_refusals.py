"""Refusals when a model is compiled; each message has the place, the value and a remedy."""

import mujoco
import numpy as np
import pytest

from tests.plugin.rigs import refused

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
  <tendon>
    <spatial name="flexor"><site site="a"/><site site="g"/><site site="b"/></spatial>
    <spatial name="extensor"><site site="a"/><site site="b"/></spatial>
    <spatial name="stiff" stiffness="40"><site site="a"/><site site="b"/></spatial>
    <spatial name="wrapped"><site site="a"/><geom geom="peg"/><site site="b"/></spatial>
    <spatial name="forked"><site site="a"/><site site="g"/><pulley divisor="2"/><site site="g"/>
      <site site="b"/></spatial>
    <fixed name="coupling"><joint joint="knuckle" coef="1"/></fixed>
  </tendon>
  <actuator>{actuators}</actuator>
  <sensor>{sensors}</sensor>
</mujoco>
"""
LAW = {"tendon": "flexor", "axial_stiffness": "1000", "friction": "0.1"}


def instance(name, **values):
    keys = "".join(f'<config key="{k}" value="{v}"/>' for k, v in values.items() if v is not None)
    return f'<instance name="{name}">{keys}</instance>'


def compiled(*instances, sensors="", actuators=""):
    return mujoco.MjModel.from_xml_string(
        HAND.format(instances="".join(instances), sensors=sensors, actuators=actuators)
    )


def check_refused(facts, *instances, **more):
    with refused(*facts):
        compiled(*instances, **more)
    # the process and the plugin are as good as before
    model = compiled(instance("sound", **LAW))
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data)
    assert np.isfinite(data.plugin_state).all()


KNUCKLE = {"reel_joint": "knuckle", "reel_radius": "0.01"}
WHERE = "plugin tendon_mj.sheath instance 'bad': "
CASES = [
    ({"tendon": "flexer"}, "unknown tendon 'flexer'", "'flexor'", "'coupling'"),
    ({"tendon": None}, "unknown tendon ''"),
    ({"friction": "-0.1"}, "friction = -0.1 [-]", "≥ 0"),
    ({"friction": "nan"}, "friction = nan [-]"),
    ({"friction": "inf"}, "friction = inf [-]"),
    ({"friction": "1e999"}, "friction = inf [-]"),
    ({"pretension": "1e308"}, "pretension = 1e+308 [N]", "0 to 1e+30"),
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
    ({"backlash": "-1e-3"}, "backlash = -0.001 [m]", "≥ 0"),
    ({"friction_drift": "nan"}, "friction_drift = nan [1/s]"),
    ({"stribeck_friction": "0.1"}, "stribeck_friction = 0.1", "stribeck_velocity > 0 [m/s]"),
    ({"creep": "0.1", "creep_time": "0"}, "creep = 0.1", "creep_time > 0 [s]"),
    ({"tendon": "coupling"}, "tendon 'coupling'", "fixed tendon"),
    ({"tendon": "wrapped", "guides": "1"}, "'wrapped'", "arc_guides"),
    ({"arc_guides": "0"}, "arc_guides = 0"),
    ({"inner_guides": "some"}, "inner_guides = 'some'"),
    ({"arc_guides": "894783", "inner_guides": "154"}, "arc_guides = 894783 inner_guides = 154"),
    ({"guides": "999999"}, "guides = 999999", "16777216"),
    ({"tendon": "forked"}, "tendon 'forked'", "pulley"),
    ({"tendon": "stiff", **KNUCKLE}, "tendon 'stiff'", "40 0 0"),
    ({"tendon": "stiff", "pretension": "3"}, "pretension = 3", "'stiff'"),
    ({"reel_joint": "knuckle"}, "reel_joint and reel_radius"),
    ({"reel_radius": "0.01"}, "reel_joint and reel_radius"),
    ({"output_joint": "knuckle"}, "output_joint and output_radius"),
    ({"reel_joint": "knukle", "reel_radius": "0.01"}, "reel_joint: ", "'knukle'", "'knuckle'"),
    ({"reel_joint": "socket", "reel_radius": "0.01"}, "reel_joint 'socket'", "hinge or slide"),
    ({"output_joint": "loose", "output_radius": "1"}, "output_joint 'loose'", "hinge or slide"),
    ({"reel_joint": "knuckle", "reel_radius": "0"}, "reel_radius = 0 [m]"),
    ({"guides": "3"}, "guides = 3", "'flexor' runs over 1"),
    ({"guides": "0"}, "guides = 0", "'flexor' runs over 1"),
    ({"guides": "-1"}, "guides = '-1'"),
    ({"guides": "many"}, "guides = 'many'"),
    ({"guides": "²"}, "guides = '²'"),
    # text that C and Python read differently, or that is not to the letter
    ({"axial_stiffness": "1_000"}, "axial_stiffness = '1_000'"),
    ({"friction": "٣"}, "friction = '٣'"),
    ({"friction": " 0.1"}, "friction = ' 0.1'"),
    ({"friction": "0x1p-3"}, "friction = '0x1p-3'"),
    ({"tendon": " tendon "}, "unknown tendon ' tendon '"),
    ({"tendon": "%s%n%d"}, "unknown tendon '%s%n%d'"),
]


@pytest.mark.parametrize(("values", "facts"), [(v, f) for v, *f in CASES], ids=str)
def test_a_bad_configuration_is_named_with_its_place_and_value(values, facts):
    check_refused([WHERE, *facts], instance("bad", **(LAW | values)))


def test_an_unknown_attribute():
    check_refused(["attribute", "frictoin"], instance("bad", **LAW, frictoin="0.1"))


def test_an_unknown_site():
    spec = mujoco.MjSpec.from_string(HAND.format(instances="", sensors="", actuators=""))
    spec.tendon("flexor").wrap_site("nowhere")
    with refused("nowhere"):
        spec.compile()


def test_two_sheaths_on_a_tendon():
    check_refused(
        ["'flexor'", "a tendon has one sheath"], *(instance(k, **LAW) for k in ("a", "b"))
    )


@pytest.mark.parametrize(
    ("values", "facts"),
    [
        ({"tendon": "flexor", "sensor": "tensoin"}, ["unknown sensor 'tensoin'", "'tension'"]),
        ({"tendon": "flexor", "sensor": "slip", "friction": "1"}, ["a sensor takes no friction"]),
        ({"tendon": "extensor", "sensor": "slip"}, ["'extensor'", "'flexor'"]),
        ({"tendon": "flexr", "sensor": "slip"}, ["unknown tendon 'flexr'", "'flexor'"]),
    ],
)
def test_a_sensor_that_cannot_show_its_quantity(values, facts):
    sensor = '<plugin name="s" plugin="tendon_mj.sheath" instance="bad"/>'
    instances = instance("sheath", **LAW), instance("bad", **values)
    check_refused([WHERE, *facts], *instances, sensors=sensor)


def test_a_message_of_any_length_is_survived():
    with refused("friction = 'xxx"):
        compiled(instance("bad", **(LAW | {"friction": "x" * 5000})))


def test_a_sheath_without_guides_or_name_is_no_mistake():
    model = compiled(instance("straight", **(LAW | {"tendon": "extensor", "guides": "0"})))
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data)
    assert np.isfinite(data.plugin_state).all()


def test_a_reel_on_another_tendon():
    reel = '<plugin name="r" plugin="tendon_mj.sheath" instance="bad" tendon="extensor"/>'
    check_refused([WHERE, "'r'", "'extensor'", "'flexor'"], instance("bad", **LAW), actuators=reel)
