"""Cables between actuators and joints that a model does not draw."""

import math
import warnings

import mujoco
import numpy as np
import pytest

from tendon_mj import (
    Parameters,
    TendonError,
    TendonWarning,
    add_cable_drive,
    add_friction,
    remove_friction,
    view_sheath,
)
from tests.refusals import refusing, silent
from tests.rigs import sheath

RADIUS, BEND, MU = 0.01, 3.0, 0.1
EXPONENT = MU * BEND
CABLE = {"radius": RADIUS, "bend": BEND, "friction": MU}
HAND = """
<mujoco>
  <option timestep=".002" integrator="{integrator}" gravity="0 0 {gravity}"/>
  <default>
    <joint axis="0 1 0" damping="{damping}"/>
    <geom size=".02" pos="0 0 .1" mass=".1" contype="0"/>
  </default>
  <worldbody>
    <body><joint name="mcp" range="-90 90"/><geom/>
      <body pos="0 0 .1"><joint name="pip"/><geom/>
        <body pos="0 0 .1"><joint name="dip"/><geom/></body>
      </body>
    </body>
  </worldbody>
  <tendon>
    <fixed name="coupled">
      <joint joint="pip" coef="{unit}"/><joint joint="dip" coef="{unit}"/>
    </fixed>
  </tendon>
  <actuator>
    <position name="mcp" joint="mcp" kp="3" kv=".1" inheritrange="1" forcerange="-2 2"/>
    <motor name="curl" tendon="coupled" gear="{gear}"/>
  </actuator>
  <keyframe><key qpos=".1 .2 .3" ctrl=".1 .5"/></keyframe>
</mujoco>
"""


def hand(integrator="Euler", gravity=-9.81, damping=0.02, unit=1.0, gear=1.0):
    """A finger with a servo on one joint, and a motor on two that a fixed tendon couples."""
    return mujoco.MjSpec.from_string(HAND.format(**locals()))


def moved(model, steps=1000):
    """Positions of a hand whose actuators follow sines."""
    data, positions = mujoco.MjData(model), []
    mujoco.mj_resetDataKeyframe(model, data, 0)
    for _ in range(steps):
        data.ctrl[:] = math.sin(3.0 * data.time), 0.3 * math.cos(5.0 * data.time)
        mujoco.mj_step(model, data)
        positions.append(data.qpos.copy())
    return np.array(positions)


def drum(damping=0.5, more=""):
    """A joint that a motor turns."""
    return mujoco.MjSpec.from_string(
        f"""<mujoco><option timestep=".001" gravity="0 0 0"/>
        <worldbody><body><joint name="j" axis="0 1 0" damping="{damping}"/>
        <geom size=".02" pos="0 0 .1" mass=".1"/></body></worldbody>
        <actuator><motor name="m" joint="j"/>{more}</actuator></mujoco>"""
    )


@pytest.mark.parametrize("integrator", ["Euler", "implicit", "implicitfast", "RK4"])
def test_without_friction_a_hand_moves_as_before_and_keeps_its_sizes(integrator):
    stock = hand(integrator).compile()
    with silent(TendonWarning):
        spec = add_cable_drive(hand(integrator), "*", **CABLE | {"friction": 0.0}, pretension=20.0)
    model = spec.compile()
    assert (model.nq, model.nv, model.nu) == (stock.nq, stock.nv, stock.nu)
    assert (model.actuator_trnid == stock.actuator_trnid).all()
    assert moved(model) == pytest.approx(moved(stock), abs=1e-9)


def two_elastic_cables(force, slides, pretension):
    """Force behind two equal elastic cables, by their tensions and the length that they keep."""
    there, back = -math.expm1(-EXPONENT), math.expm1(EXPONENT)  # means of T_in e^∓μθ, times λ
    shares = (there, back) if slides > 0 else (back, there)  # of a cable that turns the joint on
    one, other = np.linalg.solve([[1.0, -1.0], shares], [force, 2.0 * pretension * EXPONENT])
    if other < 0.0:  # slack
        one, other = force, 0.0
    if one < 0.0:
        one, other = 0.0, -force
    return one * math.exp(-slides * EXPONENT) - other * math.exp(slides * EXPONENT)


@pytest.mark.parametrize("pretension", [0.0, 20.0])
@pytest.mark.parametrize("load", [0.0, 0.9, -0.9])
def test_a_slow_sine_loses_what_two_elastic_cables_lose_forward_and_back(pretension, load):
    """Under a load on the joint, which also drives the motor back."""
    model = add_cable_drive(drum(), "m", **CABLE, pretension=pretension).compile()
    data, senses = mujoco.MjData(model), set()
    view = view_sheath(model, data, "j_cable")
    for _ in range(2000):
        data.ctrl[0] = 0.7 * math.sin(math.pi * data.time)
        data.qfrc_applied[0] = load
        mujoco.mj_step(model, data)
        slides = np.sign(data.qvel[0])
        if view.slip[0] != 0.0 and view.slip[0] == slides:  # it turned so in this step and the last
            senses.add((slides, np.sign(data.ctrl[0])))
            expected = two_elastic_cables(data.ctrl[0] / RADIUS, slides, pretension)
            assert view.input_tension == pytest.approx(data.ctrl[0] / RADIUS, abs=1e-9)
            assert view.output_tension == pytest.approx(expected, rel=1e-6, abs=1e-6)
            torque = data.ctrl[0] + data.qfrc_passive[0] + 0.5 * data.qvel[0]
            assert torque == pytest.approx(RADIUS * expected, abs=0.5 * 1e-3 * abs(data.qacc[0]))
    assert len(senses) >= 2


@pytest.mark.parametrize("pretension", [0.0, 20.0])
@pytest.mark.parametrize("share", [0.99, 1.01])
def test_a_cable_bears_the_load_of_a_joint_that_an_equality_couples_to_its_own(pretension, share):
    couples = '<equality><joint joint1="pip" joint2="mcp" polycoef="0 2 0 0 0"/></equality>'
    text = HAND.format(integrator="Euler", gravity=0.0, damping=0.02, unit=1.0, gear=1.0)
    spec, force = mujoco.MjSpec.from_string(text.replace("<tendon>", couples + "<tendon>")), 20.0
    spec.delete(spec.actuator("curl"))
    spec.delete(spec.keys[0])
    spec.actuator("mcp").set_to_motor()
    model = add_cable_drive(spec, "mcp", **CABLE, pretension=pretension).compile()
    data = mujoco.MjData(model)
    data.ctrl[0] = RADIUS * force
    mujoco.mj_step(model, data, 50)  # it slides on
    view = view_sheath(model, data, "mcp_cable")
    assert view.output_tension == pytest.approx(two_elastic_cables(force, 1.0, pretension))
    least = RADIUS * two_elastic_cables(force, 1.0, pretension)
    data.qfrc_applied[1] = -0.5 * share * least  # of which twice as much arrives
    mujoco.mj_step(model, data, 3000)
    holds = share > 1.0
    assert (abs(data.qvel[0]) < 1e-9) == holds
    if holds:
        assert RADIUS * view.output_tension == pytest.approx(share * least, rel=1e-6)


@pytest.mark.parametrize("integrator", ["Euler", "implicitfast"])
@pytest.mark.parametrize("seed", range(5))
def test_a_load_within_the_band_rests_after_any_motion(seed, integrator):
    rng = np.random.default_rng(seed)
    spec, pretension = hand(integrator, 0.0, 0.2), rng.choice([0.0, 20.0])
    spec.delete(spec.actuator("mcp"))
    spec.add_actuator(name="mcp", trntype=mujoco.mjtTrn.mjTRN_JOINT, target="mcp")
    model = add_cable_drive(spec, "*", **CABLE, pretension=pretension).compile()
    data = mujoco.MjData(model)
    views = [view_sheath(model, data, name) for name in ("mcp_cable", "coupled")]
    motor = [model.actuator(name).id for name in ("mcp", "curl")]
    for _ in range(rng.integers(1, 400)):
        data.ctrl[:] = 0.2 * rng.normal(size=2)
        mujoco.mj_step(model, data)
    force = rng.uniform(-30.0, 30.0, 2)
    band = np.maximum(2.0 * pretension * EXPONENT, -np.abs(force) * math.expm1(-EXPONENT))
    held = RADIUS * (force + rng.uniform(-0.8, 0.8, 2) * band)
    data.ctrl[motor] = RADIUS * force
    data.qfrc_applied[:] = -held[0], -held[1], -held[1]
    mujoco.mj_step(model, data, 4000)
    work, place = [view.friction_work.sum() for view in views], data.qpos.copy()
    mujoco.mj_step(model, data, 1000)
    assert abs(data.qvel).max() < 1e-12
    assert data.qpos == pytest.approx(place, abs=1e-12)
    assert [view.friction_work.sum() for view in views] == pytest.approx(work, abs=1e-12)
    assert [RADIUS * view.output_tension for view in views] == pytest.approx(held, abs=1e-9)


DRAWN = """
<mujoco>
  <option timestep=".001"/>
  <worldbody>
    <site name="motor" pos="-.1 0 .015"/><site name="side" pos=".02 0 .02"/>
    <body><joint name="j" axis="0 -1 0" damping=".02" stiffness=".5"/>
      <geom size=".02" pos="0 0 .1" mass=".1"/>
      <geom name="drum" type="cylinder" size=".015" fromto="0 -.01 0 0 .01 0" mass="0"/>
      <site name="end" pos="0 0 -.03"/>
    </body>
  </worldbody>
  <tendon>
    <spatial name="cable">
      <site site="motor"/><geom geom="drum" sidesite="side"/><site site="end"/>
    </spatial>
  </tendon>
  <actuator>{actuator}</actuator>
</mujoco>
"""


def test_it_moves_as_a_cable_that_is_drawn_over_a_drum():
    """The motor of one pulls its tendon, that of the other turns the joint; both only pull."""
    drawn = mujoco.MjSpec.from_string(DRAWN.format(actuator='<motor tendon="cable" gear="-1"/>'))
    add_friction(drawn, "cable", friction=MU, extra_bend=BEND, inner_guides=1)
    turned = mujoco.MjSpec.from_string(DRAWN.format(actuator='<motor joint="j" gear=".015"/>'))
    add_cable_drive(turned, "*", **CABLE | {"radius": 0.015})
    runs = []
    for spec, name in ((drawn, "cable"), (turned, "j_cable")):
        model = spec.compile()
        data = mujoco.MjData(model)
        view, shown = view_sheath(model, data, name), []
        for k in range(2000):
            data.ctrl[0] = 10.0 + 9.0 * math.sin(0.006 * k)
            mujoco.mj_step(model, data)
            shown.append([data.qpos[0], view.tension[1], view.friction_work[0]])
        runs.append(np.array(shown))
    assert np.ptp(runs[0][:, 0]) > 0.3
    assert runs[1] == pytest.approx(runs[0], rel=1e-6, abs=1e-6)


@pytest.mark.parametrize("pretension", [0.0, 5.0])
@pytest.mark.parametrize(
    "law",
    [
        {"static_friction": 0.3},
        {"static_friction": 0.3, "efficiency": 0.7},
        {"stribeck_friction": 0.3, "stribeck_velocity": 0.01},
        {"constant_friction": 2.0, "friction_drift": 0.5},
    ],
)
def test_it_turns_alike_either_way(law, pretension):
    model = add_cable_drive(drum(), "m", **CABLE, pretension=pretension, **law).compile()
    paths = []
    for way in (1.0, -1.0):
        data, path = mujoco.MjData(model), []
        for _ in range(1500):
            data.ctrl[0] = way * 0.6 * math.sin(4.0 * data.time)
            mujoco.mj_step(model, data)
            path.append(way * data.qpos[0])
        paths.append(path)
    assert np.ptp(paths[0]) > 0.1
    np.testing.assert_allclose(*paths, rtol=0.0, atol=1e-12)


@pytest.mark.parametrize(("pretension", "lost"), [(30.0, 10.0), (2.0, 7.0), (0.0, 5.0)])
def test_constant_friction_acts_on_both_cables_and_takes_no_more_than_their_tension(
    pretension, lost
):
    law = {"friction": 0.0, "constant_friction": 5.0, "pretension": pretension}
    model = add_cable_drive(drum(), "m", **CABLE | law).compile()
    data = mujoco.MjData(model)
    data.ctrl[0] = 0.2
    mujoco.mj_step(model, data, 500)
    view = view_sheath(model, data, "j_cable")
    assert data.qvel[0] > 0.1
    assert view.input_tension - view.output_tension == pytest.approx(lost, rel=1e-12)


def test_the_unit_of_coupled_joints_does_not_matter():
    """A radius counts for as much as the unit of the coefficients."""
    hands = [hand(gravity=0.0, unit=unit, gear=1.0 / unit) for unit in (1.0, 100.0)]
    for spec, unit in zip(hands, (1.0, 100.0), strict=True):
        cable = CABLE | {"radius": RADIUS / unit}
        add_cable_drive(spec, "curl", **cable, pretension=5.0, constant_friction=1.0)
    assert moved(hands[0].compile()) == pytest.approx(moved(hands[1].compile()), abs=1e-9)


def test_all_actuators_of_a_joint_pull_its_one_cable():
    model = add_cable_drive(
        drum(more='<motor name="n" joint="j" gear="2"/>'), "*", **CABLE
    ).compile()
    data = mujoco.MjData(model)
    data.ctrl[:] = 0.1, 0.2
    mujoco.mj_forward(model, data)
    assert model.ntendon == 1
    assert view_sheath(model, data, "j_cable").input_tension == pytest.approx(0.5 / RADIUS)


def test_friction_of_a_joint_and_of_a_tendon_that_turns_it_alone_counts_once():
    """Whichever actuator comes first, and in one call or in two."""
    for chosen in (["m", "b"], ["b", "m"]):
        spec = drum()
        spec.add_tendon(name="t").wrap_joint("j", 1.0)
        pull = spec.add_actuator(name="b", target="t", trntype=mujoco.mjtTrn.mjTRN_TENDON)
        pull.set_to_motor()
        with refusing(TendonError, "turns joint 'j' | count twice"):
            add_cable_drive(spec.copy(), chosen, **CABLE)
        add_cable_drive(spec, chosen[0], **CABLE)
        with refusing(TendonError, "cable"):
            add_cable_drive(spec, chosen[1], **CABLE)


def test_friction_and_pretension_are_live_and_elasticity_is_no_parameter():
    model = add_cable_drive(drum(), "m", **CABLE).compile()
    data = mujoco.MjData(model)
    live = Parameters(model, data)
    assert not {"j_cable_sheath.axial_stiffness", "j_cable_sheath.backlash"} & set(live)
    live["j_cable.friction"], live["j_cable.pretension"] = 2.0 * MU, 10.0
    with refusing(TendonError, "radius = 0 [m]"):
        live["j_cable.radius"] = 0.0
    data.ctrl[0] = 0.5
    mujoco.mj_step(model, data, 20)
    expected = 0.5 / RADIUS - max(2 * 10.0 * 2 * EXPONENT, 50.0 * -math.expm1(-2 * EXPONENT))
    assert view_sheath(model, data, "j_cable").output_tension == pytest.approx(expected)


def test_what_was_added_goes_without_a_trace():
    stock, spec = hand().compile(), add_cable_drive(hand(), "*", **CABLE)
    model = remove_friction(spec, "*").compile()
    assert (model.ntendon, model.nplugin, model.nsensor) == (stock.ntendon, 0, 0)
    assert (moved(model, 50) == moved(stock, 50)).all()


def test_a_pattern_says_what_it_leaves_out():
    spec = hand()
    body = spec.worldbody.add_body(name="ball")
    body.add_joint(name="ball", type=mujoco.mjtJoint.mjJNT_BALL)
    body.add_geom(size=[0.1, 0, 0])
    spec.add_actuator(name="push", trntype=mujoco.mjtTrn.mjTRN_JOINT, target="ball")
    with pytest.warns(TendonWarning, match="left as they are: 'push': acts on joint 'ball'"):
        add_cable_drive(spec, "*", **CABLE)
    with refusing(TendonError, "'push' acts on joint 'ball'"):
        add_cable_drive(spec, "push", **CABLE)


def test_the_range_of_a_tendon_s_actuators_does_not_limit_those_on_its_joint():
    spec = add_cable_drive(drum(), "m", **CABLE)
    cable = spec.tendon("j_cable")
    cable.actfrclimited, cable.actfrcrange = True, [-0.1, 0.1]
    model = spec.compile()
    data = mujoco.MjData(model)
    data.ctrl[0] = 0.5
    mujoco.mj_step(model, data)
    assert data.sensor("j_cable_input_tension").data[0] == pytest.approx(0.5 / RADIUS)


@pytest.mark.parametrize(("field", "value"), [("actfrcrange", [-1.0, 1.0]), ("actgravcomp", True)])
def test_what_acts_on_a_joint_past_its_cable_is_warned_of(field, value):
    spec = drum()
    setattr(spec.joint("j"), field, value)
    name = field.replace("act", "actuator")
    with pytest.warns(TendonWarning, match=f"{name} of joint 'j'"):
        add_cable_drive(spec, "*", **CABLE)


@pytest.mark.parametrize(
    ("call", "facts"),
    [
        (lambda: add_friction(drum(), "*", friction=MU), "no tendon | add_cable_drive(spec, "),
        (lambda: add_friction(drum(), "m", friction=MU), "no tendon | add_cable_drive(spec, "),
        (lambda: add_friction(hand(), "coupled", friction=MU), "add_cable_drive(spec, 'curl'"),
        (lambda: add_friction(hand(), "*", friction=MU), "add_cable_drive(spec, 'curl'"),
        (lambda: add_cable_drive(hand(), "curls", **CABLE), "did you mean 'curl'"),
        (lambda: add_cable_drive(hand(), "x*", **CABLE), "no actuator of the model | 'curl'"),
        (lambda: add_cable_drive(drum(), "m", **CABLE | {"radius": 0.0}), "radius = 0 [m]"),
        (lambda: add_cable_drive(drum(), "m", **CABLE | {"friction": None}), "friction = None"),
        (lambda: add_cable_drive(drum(), "m", **CABLE, slack=1.0), "'slack'"),
        (lambda: add_cable_drive(drum(), "m", **CABLE, sensors="slip"), "sensors = 'slip'"),
        (
            lambda: add_cable_drive(add_cable_drive(drum(), "m", **CABLE), "m", **CABLE),
            "has a cable already | 'j_cable_sheath'",
        ),
    ],
)
def test_a_refusal_names_the_way_out(call, facts):
    with refusing(TendonError, facts):
        call()


@pytest.mark.parametrize(
    ("config", "facts"),
    [
        ({"radius": None}, "radius = ''"),
        ({"inner_guides": 2, "guides": 2}, "inner_guides = '2'"),
        ({"axial_stiffness": 1e5}, "axial_stiffness = 100000.0 | not drawn"),
        ({"backlash": 1e-3}, "backlash = 0.001 | not drawn"),
        ({"load_gradient": 0.05}, "load_gradient = 0.05 | not drawn"),
        ({"friction_gradient": 30.0}, "friction_gradient = 30.0 | not drawn"),
        ({"spring": "cable"}, "spring = cable | not drawn"),
        ({"tendon": "idle"}, "no actuator acts on it | add_cable_drive"),
    ],
)
def test_a_configuration_that_no_cable_has_is_refused(config, facts):
    one = {"tendon": "cable", "inner_guides": 1, "friction": MU, "radius": RADIUS}
    text = f"""<mujoco>{sheath(**one | config)}
    <worldbody><body><joint name="j"/><geom size=".1"/>
      <body><joint name="k"/><geom size=".1"/></body></body></worldbody>
    <tendon><fixed name="cable"><joint joint="j" coef="1"/></fixed>
    <fixed name="idle"><joint joint="k" coef="1"/></fixed></tendon>
    <actuator><motor joint="j"/></actuator></mujoco>"""
    with refusing(ValueError, facts):
        mujoco.MjModel.from_xml_string(text)


@pytest.mark.parametrize("policy", ["auto", "allowed", "init", "never"])
def test_a_joint_of_a_body_that_may_fall_asleep_is_refused(policy):
    spec, awake = drum(), policy in ("auto", "never")  # MuJoCo keeps awake what an actuator moves
    spec.option.enableflags |= mujoco.mjtEnableBit.mjENBL_SLEEP
    body = spec.joint("j").parent
    body.name = "link"
    body.sleep = getattr(mujoco.mjtSleepPolicy, f"mjSLEEP_{policy.upper()}")
    add_cable_drive(spec, "m", **CABLE)
    with silent() if awake else refusing((ValueError, mujoco.FatalError), "'link'", "never"):
        model = spec.compile()
        mujoco.mj_step(model, mujoco.MjData(model))


@pytest.mark.parametrize("efficiency", [1.0, 0.8])
@pytest.mark.parametrize("share", [0.98, 1.02])
def test_cables_that_no_force_of_a_servo_moves_are_told(share, efficiency):
    """Whose limit of 2 N m ends at 2Pμφ r/η."""
    drive = CABLE | {"efficiency": efficiency}
    drive["pretension"] = share * efficiency * 2.0 / (2.0 * EXPONENT * RADIUS)
    spec = hand(gravity=0.0)
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        model = add_cable_drive(spec, "mcp", **drive).compile()
    data = mujoco.MjData(model)
    data.ctrl[0] = 1.5
    mujoco.mj_step(model, data, 200)
    holds = share > 1.0
    assert (abs(data.qpos[0]) < 1e-9) == holds
    assert any("nothing moves" in str(each.message) for each in said) == holds
