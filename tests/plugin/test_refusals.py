"""Refusals when a model is compiled; each message says what is wrong, where, and a remedy."""

import mujoco
import numpy as np
import pytest

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


def refused(pattern, *instances, **more):
    with pytest.raises(ValueError, match=pattern):
        compiled(*instances, **more)
    # the process and the plugin are as good as before
    model = compiled(instance("sound", **LAW))
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data)
    assert np.isfinite(data.plugin_state).all()


WHERE = r"plugin tendon_mj\.sheath instance 'bad': "
CASES = [
    ({"tendon": "flexer"}, r"unknown tendon 'flexer'; did you mean 'flexor'\? .*'coupling'"),
    ({"tendon": None}, r"unknown tendon ''"),
    ({"friction": "-0.1"}, r"friction = -0\.1 \[-\] must be finite and ≥ 0"),
    ({"friction": "nan"}, r"friction = nan \[-\] must be finite"),
    ({"friction": "inf"}, r"friction = inf \[-\] must be finite"),
    ({"friction": "1e999"}, r"friction = inf \[-\] must be finite"),
    ({"pretension": "1e308"}, r"pretension = 1e\+308 \[N\] is no size .*, 0 to 1e\+30"),
    ({"axial_stiffness": "1e-320"}, r"axial_stiffness = .* is no size .*, 1e-30 to 1e\+30"),
    ({"friction": "low"}, r"friction = 'low' is not a number"),
    ({"friction": "0.1 0.2"}, r"friction = '0\.1 0\.2' is not a number"),
    ({"friction": None}, r"friction is missing \(its unit is -\)"),
    ({"axial_stiffness": "0"}, r"axial_stiffness = 0 \[N\] must be finite and > 0"),
    ({"axial_stiffness": "-5"}, r"axial_stiffness = -5 \[N\] must be finite and > 0"),
    ({"axial_stiffness": None}, r"axial_stiffness is missing \(its unit is N\)"),
    ({"pretension": "-1"}, r"pretension = -1 \[N\] must be finite and ≥ 0"),
    ({"constant_friction": "-1"}, r"constant_friction = -1 \[N\] must be finite and ≥ 0"),
    ({"axial_damping": "inf"}, r"axial_damping = inf \[N s\] must be finite and ≥ 0"),
    ({"static_friction": "0.05"}, r"static_friction = 0\.05 must be ≥ friction = 0\.1"),
    (
        {"direction_asymmetry": "1"},
        r"direction_asymmetry = 1 \[-\] must be finite and > -1 and < 1",
    ),
    ({"backlash": "-1e-3"}, r"backlash = -0\.001 \[m\] must be finite and ≥ 0"),
    ({"friction_drift": "nan"}, r"friction_drift = nan \[1/s\] must be finite"),
    ({"stribeck_friction": "0.1"}, r"stribeck_friction = 0\.1 needs stribeck_velocity > 0 \[m/s\]"),
    ({"creep": "0.1", "creep_time": "0"}, r"creep = 0\.1 needs creep_time > 0 \[s\]"),
    ({"tendon": "coupling"}, r"tendon 'coupling' is a fixed tendon; only a spatial one"),
    (
        {"tendon": "wrapped", "guides": "1"},
        r"'wrapped' wraps around geoms: .* arc_guides has to be",
    ),
    ({"arc_guides": "0"}, r"arc_guides = 0 must be 1 or more"),
    ({"inner_guides": "some"}, r"inner_guides = 'some' is not a count"),
    (
        {"arc_guides": "894783", "inner_guides": "154"},
        r"arc_guides = 894783 inner_guides = 154 makes room for \d+ guides, .* more than 16777216",
    ),
    ({"guides": "999999"}, r"guides = 999999 makes room for 999999 guides"),
    ({"tendon": "forked"}, r"tendon 'forked' branches at a pulley"),
    (
        {"tendon": "stiff", "reel_joint": "knuckle", "reel_radius": "0.01"},
        r"tendon 'stiff' has a stiffness of its own, 40 0 0",
    ),
    ({"tendon": "stiff", "pretension": "3"}, r"pretension = 3 has no meaning where"),
    ({"reel_joint": "knuckle"}, r"reel_joint and reel_radius go together"),
    ({"reel_radius": "0.01"}, r"reel_joint and reel_radius go together"),
    ({"output_joint": "knuckle"}, r"output_joint and output_radius go together"),
    ({"reel_joint": "knukle", "reel_radius": "0.01"}, r"reel_joint: unknown joint 'knukle'; did y"),
    ({"reel_joint": "socket", "reel_radius": "0.01"}, r"reel_joint 'socket' is no hinge or slide"),
    ({"output_joint": "loose", "output_radius": "1"}, r"output_joint 'loose' is no hinge or slide"),
    ({"reel_joint": "knuckle", "reel_radius": "0"}, r"reel_radius = 0 \[m\] must be finite and "),
    ({"guides": "3"}, r"guides = 3, but tendon 'flexor' runs over 1 between its ends"),
    ({"guides": "0"}, r"guides = 0, but tendon 'flexor' runs over 1 between its ends"),
    ({"guides": "-1"}, r"guides = '-1' is not a count"),
    ({"guides": "many"}, r"guides = 'many' is not a count"),
]


@pytest.mark.parametrize(("values", "pattern"), CASES, ids=[str(v) for v, _ in CASES])
def test_a_bad_configuration_is_named_with_its_place_and_value(values, pattern):
    refused(WHERE + ".*" + pattern, instance("bad", **(LAW | values)))


def test_an_unknown_attribute():
    refused("unrecognized attribute.*frictoin", instance("bad", **LAW, frictoin="0.1"))


def test_an_unknown_site():
    spec = mujoco.MjSpec.from_string(HAND.format(instances="", sensors="", actuators=""))
    spec.tendon("flexor").wrap_site("nowhere")
    with pytest.raises(ValueError, match="nowhere"):
        spec.compile()


def test_two_sheaths_on_a_tendon():
    pattern = r"tendon 'flexor' already runs in sheath '(one|two)'; a tendon has one sheath"
    refused(pattern, instance("one", **LAW), instance("two", **LAW))


@pytest.mark.parametrize(
    ("values", "pattern"),
    [
        (
            {"tendon": "flexor", "sensor": "tensoin"},
            r"unknown sensor 'tensoin'; did you mean 'tens",
        ),
        ({"tendon": "flexor", "sensor": "slip", "friction": "1"}, r"a sensor takes no friction"),
        ({"tendon": "extensor", "sensor": "slip"}, r"unknown sheathed tendon 'extensor'.*'flexor'"),
        ({"tendon": "flexr", "sensor": "slip"}, r"unknown tendon 'flexr'; did you mean 'flexor'"),
    ],
)
def test_a_sensor_that_cannot_show_what_it_is_asked_for(values, pattern):
    sensor = '<plugin name="s" plugin="tendon_mj.sheath" instance="bad"/>'
    refused(WHERE + pattern, instance("sheath", **LAW), instance("bad", **values), sensors=sensor)


@pytest.mark.parametrize(
    ("name", "text"),
    [("axial_stiffness", "1_000"), ("friction", "٣"), ("friction", " 0.1"), ("friction", "0x1p-3")],
)
def test_a_number_that_c_and_python_read_differently_is_none(name, text):
    refused(rf"{name} = '{text}' is not a number", instance("bad", **(LAW | {name: text})))


def test_a_name_is_taken_to_the_letter():
    refused(r"unknown tendon ' tendon '", instance("bad", **(LAW | {"tendon": " tendon "})))


def test_a_count_is_of_plain_digits():
    refused(r"guides = '²' is not a count", instance("bad", **(LAW | {"guides": "²"})))


def test_a_percent_sign_is_no_format():
    refused(WHERE + r"unknown tendon '%s%n%d'", instance("bad", **(LAW | {"tendon": "%s%n%d"})))


def test_a_message_of_any_length_is_survived():
    with pytest.raises(ValueError, match="friction = 'xxx"):
        compiled(instance("bad", **(LAW | {"friction": "x" * 5000})))


def test_a_sheath_without_guides_or_name_is_no_mistake():
    model = compiled(instance("straight", **(LAW | {"tendon": "extensor", "guides": "0"})))
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data)
    assert np.isfinite(data.plugin_state).all()


def test_a_reel_on_another_tendon():
    reel = '<plugin name="r" plugin="tendon_mj.sheath" instance="bad" tendon="extensor"/>'
    pattern = WHERE + r"reel 'r' acts on tendon 'extensor', the sheath on 'flexor'"
    refused(pattern, instance("bad", **LAW), actuators=reel)
