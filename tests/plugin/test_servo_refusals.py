"""A servo that cannot work is refused when the model is compiled."""

import mujoco
import numpy as np
import pytest

from tendon_mj import Parameters, add_servo
from tendon_mj.errors import InvalidValueError, UnknownNameError
from tests.refusals import refusing
from tests.rigs import config, hand, instance, plugin, respond, rope, simulated, spatial

FLEXOR = {"axial_stiffness": 1000, "reel_joint": "motor", "reel_radius": 0.01}
SHEATHS = (
    instance("sheath", tendon="flexor", friction=0.1, **FLEXOR),
    instance("unwound", tendon="idle", friction=0.1, axial_stiffness=1000),
)
GAINS = {"tendon": "flexor", "tension_gain": "7", "velocity_gain": "2"}


def mjcf(target='joint="motor"', armature='armature=".1"', **values):
    given = config(**GAINS | values)
    return rope(
        "a; b .1 0 0",
        "",
        "a b",
        name="flexor",
        joint=f'name="motor" {armature}',
        head=f"<extension>{plugin(*SHEATHS)}{plugin(kind='servo')}</extension>",
        tendons=spatial("idle", "a b") + spatial("bare", "a b"),
        actuator=f'<plugin name="pull" plugin="tendon_mj.servo" {target}>{given}</plugin>',
        rest='<worldbody><body><joint name="other"/><geom size=".01"/></body></worldbody>',
    )


def compiled(**values):
    return mujoco.MjModel.from_xml_string(mjcf(**values))


MOTOR = 'joint="motor"'
CASES = [
    ({"tendon": "flexer"}, "tendon 'flexer'", "did you mean 'flexor'"),
    ({"tendon": None}, "tendon ''"),
    ({"tendon": "bare"}, "'bare'"),
    ({"tendon": "idle"}, "'idle'", "reel_joint"),
    ({"tension_gain": None}, "tension_gain is missing"),
    ({"velocity_gain": None}, "velocity_gain is missing", "N m s/rad"),
    ({"tension_gain": "-7"}, "tension_gain = -7 [-]", "> 0"),
    ({"velocity_gain": "-1"}, "velocity_gain = -1 [N m s/rad]", "≥ 0"),
    ({"loosening_tension_gain": "0"}, "loosening_tension_gain = 0 [-]", "> 0"),
    ({"velocity_gain": "slow"}, "velocity_gain = 'slow'"),
    ({"torque_limit": "inf"}, "torque_limit = inf [N m]"),
    ({"speed_limit": "-1"}, "speed_limit = -1 [rad/s]", "≥ 0"),
    ({"period": "-0.01"}, "period = -0.01 [s]"),
    ({"delay": "nan"}, "delay = nan [s]"),
    ({"delay": "1e12"}, "delay = ", "samples"),
    ({"motor_inertia": "0"}, "motor_inertia = 0 [kg m²]", "> 0"),
    ({"observer_friction": "-1"}, "observer_friction = -1 [-]"),
    ({"feedback": "senser"}, "feedback 'senser'"),
    ({"backdrive": "yes"}, "backdrive 'yes'"),
    ({"armature": ""}, "motor_inertia [kg m²]", "joint 'motor'"),
    ({"target": 'joint="other"'}, "'flexor' with the reel_joint 'other'"),
    ({"target": 'site="a"'}, "'pull' drives no joint"),
    ({"target": f'{MOTOR} gear="2"'}, "gear = 2"),
    ({"target": f'{MOTOR} forcerange="-1 1"'}, "forcerange", "torque_limit"),
    ({"period": "0.004", "velocity_gain": "1e3"}, "velocity_gain = 1e3 [N m s/rad]", "< 50"),
]


@pytest.mark.parametrize(("values", "facts"), [(v, f) for v, *f in CASES], ids=str)
def test_a_bad_servo_is_named_with_place_and_value(values, facts):
    with refusing(ValueError, "plugin tendon_mj.servo instance 'pull': ", *facts):
        compiled(**values)
    data = mujoco.MjData(compiled())  # the process is as good as before
    mujoco.mj_step(compiled(), data)
    assert np.isfinite(data.plugin_state).all()


def test_python_refuses_the_same_before_anything_is_added():
    spec = hand()
    before = len(spec.actuators)
    gains = {"tension_gain": 1.0, "velocity_gain": 1.0}
    with refusing(UnknownNameError, "'tendno'", "'tendon'"):
        add_servo(spec, "tendno", name="second", **gains)
    with refusing(InvalidValueError, "tension_gain = -1"):
        add_servo(spec, "tendon", name="second", **(gains | {"tension_gain": -1.0}))
    with refusing(UnknownNameError, "feedback", "'guess'"):
        add_servo(spec, "tendon", name="second", feedback="guess", **gains)
    with refusing(InvalidValueError, "'servo'"):
        add_servo(spec, "tendon", **gains)
    assert len(spec.actuators) == before
    spec.compile()


@pytest.mark.parametrize(
    ("wrong", "facts"),
    [
        ({"backdrive": "maybe"}, ["backdrive = 'maybe'"]),
        ({"backdrive": 1}, ["backdrive = 1"]),
        ({"delay": [0.1, 0.2]}, ["delay = [0.1, 0.2]", "[s]"]),
        ({"speed_limit": np.float32(-1.0)}, ["speed_limit = -1 [rad/s]", "≥ 0"]),
        ({"feedback": 3}, ["feedback '3'"]),
    ],
    ids=str,
)
def test_python_refuses_values_that_are_not_numbers_or_switches(wrong, facts):
    gains = {"tension_gain": 1.0, "velocity_gain": 1.0} | wrong
    with refusing((InvalidValueError, UnknownNameError), "servo 'second': ", *facts):
        add_servo(hand(), "tendon", name="second", **gains)


CLOCKS = {
    "runge-kutta": {"integrator": "RK4"},
    "sampled": {"period": 0.004},
    "delayed": {"delay": 0.004},
    "delayed less than a period": {"period": 0.004, "delay": 0.001},
    "both": {"period": 0.003, "delay": 0.0105},
}


def largest(**clock):
    """Velocity gain that the refusal names."""
    with pytest.raises(ValueError, match="velocity_gain = ") as refusal:
        hand(velocity_gain=1e6, **clock).compile()
    return float(str(refusal.value).rpartition("< ")[2])


def swing(share, most, **clock):
    """Speeds, over the first, of a motor turned a little that nothing but damping acts on."""
    model = hand(velocity_gain=0.8 * most, tension_gain=1e-9, **clock).compile()
    data = mujoco.MjData(model)
    parameters = Parameters(model, data)
    for gain in ("velocity_gain", "loosening_velocity_gain"):
        parameters[f"servo.{gain}"] = share * most  # live, it is not checked
    data.qvel[-1] = 1e-6
    for _ in range(3000):
        mujoco.mj_step(model, data)
        yield abs(data.qvel[-1]) / 1e-6


@pytest.mark.parametrize("clock", CLOCKS.values(), ids=CLOCKS)
def test_damping_that_is_not_implicit_is_refused_from_where_it_swings_up(clock):
    most = largest(**clock)
    *_, last = swing(0.8, most, **clock)
    assert last < 0.01
    assert any(speed > 100.0 for speed in swing(1.1, most, **clock))


def test_loosening_has_the_same_bound_and_implicit_damping_none():
    most = largest(period=0.004)
    with refusing(ValueError, "loosening_velocity_gain = "):
        hand(period=0.004, loosening_velocity_gain=1.01 * most).compile()
    seen = respond(hand(velocity_gain=1e6).compile(), np.full(500, 60.0))
    assert np.isfinite(seen).all()
    assert np.all(seen[:, 4] >= -1e-12)


def test_a_servo_has_one_actuator_and_a_motor_one_servo_and_one_without_does_nothing():
    spec = hand()
    gains = {"tendon": "tendon", "tension_gain": "1", "velocity_gain": "1"}
    spare = spec.add_plugin(name="spare", plugin_name="tendon_mj.servo", active=True)
    spare.config = gains
    data = [simulated(each.compile(), 10, ctrl=30.0) for each in (spec, hand())]
    np.testing.assert_array_equal(*(each.qpos for each in data))
    second = spec.add_actuator(name="second", trntype=mujoco.mjtTrn.mjTRN_JOINT, target="motor")
    second.plugin = spec.actuator("servo").plugin
    with refusing(ValueError, "plugin tendon_mj.servo", "2 actuators"):
        spec.compile()
    spec = hand()
    add_servo(spec, "tendon", name="second", tension_gain=7.0, velocity_gain=1.0)
    with refusing(ValueError, "'tendon'", "already has servo"):
        spec.compile()
