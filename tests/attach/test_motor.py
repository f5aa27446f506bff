"""Motors with joints of their own, which turn the joints of a model by elastic cables."""

import math
import re
import warnings

import mujoco
import numpy as np
import pytest
from scipy.optimize import root

from tendon_mj import (
    TendonError,
    TendonWarning,
    add_cable_drive,
    remove_friction,
    view_sheath,
)
from tendon_mj.attach import attach_cable_drives
from tendon_mj.theory import equivalent_backlash, reversal_backlash
from tests.attach.test_cable_drive import BEND, CABLE, EXPONENT, MU, RADIUS, drum, hand, moved
from tests.attach.test_removal import assert_equal
from tests.refusals import refusing, silent

STIFFNESS, LENGTH, PRETENSION = 2e4, 0.3, 20.0
MOTOR = CABLE | {"motor": True, "axial_stiffness": STIFFNESS, "length": LENGTH}
SLOW = MOTOR | {"armature": 1e-3, "pretension": PRETENSION, "axial_damping": 0.0}


def servoed(kp=50.0, armature=0.0, stiffness=0.0):
    """A joint that a position servo turns."""
    return mujoco.MjSpec.from_string(
        f"""<mujoco><option timestep=".001" gravity="0 0 0" integrator="implicitfast"/>
        <worldbody><body><joint name="j" axis="0 1 0" damping=".1" armature="{armature}"
          stiffness="{stiffness}"/><geom size=".02" pos="0 0 .1" mass=".1"/></body></worldbody>
        <actuator><position name="m" joint="j" kp="{kp}" kv="1"/></actuator></mujoco>"""
    )


@pytest.mark.parametrize("integrator", ["Euler", "implicitfast"])
def test_without_friction_joints_move_as_before_but_for_what_the_cables_stretch(integrator):
    errors = []
    for stiffness in (5e5, 1e6):
        stock, spec = hand(integrator, damping=0.1), hand(integrator, damping=0.1)
        for one in (stock, spec):
            one.option.timestep, one.joint("mcp").armature = 2e-4, 1e-4
        cable = MOTOR | {"axial_stiffness": stiffness, "friction": 0.0, "pretension": PRETENSION}
        model = add_cable_drive(spec, "mcp", **cable).compile()
        assert (model.actuator_ctrlrange == stock.compile().actuator_ctrlrange).all()
        paths = moved(model, 5000)[:, :3], moved(stock.compile(), 5000)
        errors.append(np.abs(paths[0] - paths[1])[:, 0].max())
    assert errors[1] < 1e-3 * math.pi
    assert errors[1] < 0.6 * errors[0]


def two_stretched_cables(torque, slides, guides):
    """Torque behind two cables that slide, by the energy of their ends and the length they keep."""
    shares = np.exp(-slides * EXPONENT * np.arange(guides + 1) / guides)
    lengths = np.full(guides + 1, LENGTH / guides)
    lengths[[0, -1]] *= 0.5

    def ends(tensions):
        pull = tensions + tensions**2 / (2.0 * STIFFNESS)
        pull /= 1.0 + PRETENSION / STIFFNESS
        return RADIUS * (pull[0] - pull[1])

    def missing(tensions):
        along = np.outer(tensions, [1.0, 1.0])[:, :1] * np.array([shares, 1.0 / shares])
        unstretched = (lengths / (1.0 + along / STIFFNESS)).sum()
        kept = 2.0 * LENGTH / (1.0 + PRETENSION / STIFFNESS)
        return [(ends(tensions) - torque) / RADIUS, (unstretched - kept) / LENGTH * STIFFNESS]

    tensions = root(missing, [PRETENSION + torque / RADIUS / 2, PRETENSION], tol=1e-13).x
    return ends(tensions * np.array([shares[-1], 1.0 / shares[-1]])), min(tensions)


@pytest.mark.parametrize("load", [0.0, 0.15, -0.15])
def test_a_slow_sine_loses_what_two_cables_lose_that_share_their_stretch(load):
    model = add_cable_drive(servoed(armature=1e-3), "m", **SLOW).compile()
    data, seen = mujoco.MjData(model), set()
    cables = [view_sheath(model, data, name) for name in ("j_cable", "j_cable_back")]
    data.qfrc_applied[0] = load
    for _ in range(4000):
        data.ctrl[0] = 0.5 * math.sin(math.pi * data.time)
        damping = 0.1 * data.qvel[0]
        mujoco.mj_step(model, data)
        slips = cables[0].slip, -cables[1].slip
        slides = slips[0][0]
        if slides and (np.concatenate(slips) == slides).all():
            into, out = -data.qfrc_passive[1], data.qfrc_passive[0] + damping
            expected, least = two_stretched_cables(into, slides, len(cables[0].slip))
            if least > 0.1:
                seen.add(slides)
                assert out == pytest.approx(expected, rel=1e-6, abs=1e-8)
    assert seen == {1.0, -1.0}


@pytest.mark.parametrize("friction", [0.03, MU, 0.3])
def test_a_motor_loses_the_motion_that_theory_has_first_and_at_a_reversal(friction):
    """The joint is clamped; the output end of a cable slides where its tension begins to change."""
    exponent = friction * BEND
    spec = servoed(kp=500.0, armature=1e6)
    model = add_cable_drive(spec, "m", **SLOW | {"friction": friction}).compile()
    data = mujoco.MjData(model)
    cables = [view_sheath(model, data, name) for name in ("j_cable", "j_cable_back")]
    drive, begins, turned, held = (PRETENSION, STIFFNESS, LENGTH), {}, 0.0, []
    first = [equivalent_backlash(way * exponent, *drive) for way in (1.0, -1.0)]
    most = 1.2 * first[0] / RADIUS
    for step in range(9000):
        data.ctrl[0] = most * min(step, 6000 - step) / 3000
        wound = RADIUS * data.qpos[1]
        mujoco.mj_step(model, data)
        for cable, way in zip(cables, (1.0, -1.0), strict=True):
            begins.setdefault((way, cable.slip[-1]), wound)
        if wound > turned:
            turned, held = wound, [cable.output_tension for cable in cables]
    for way, expected, tension in zip((1.0, -1.0), first, held, strict=True):
        assert begins[way, way] == pytest.approx(way * expected, rel=0.01)
        back = reversal_backlash(exponent, tension, STIFFNESS, LENGTH)
        assert turned - begins[way, -way] == pytest.approx(back, rel=0.01)


@pytest.mark.parametrize("seed", range(3))
def test_a_load_within_the_band_rests_after_any_motion(seed):
    rng = np.random.default_rng(seed)
    cable = SLOW | {"axial_damping": STIFFNESS * 1e-3}
    model = add_cable_drive(servoed(), "m", **cable).compile()
    data = mujoco.MjData(model)
    for _ in range(rng.integers(1, 400)):
        data.ctrl[0] = 0.2 * rng.normal()
        mujoco.mj_step(model, data)
    data.ctrl[0] = 0.1
    data.qfrc_applied[0] = 0.05 * rng.uniform(-1.0, 1.0)
    mujoco.mj_step(model, data, 6000)
    place = data.qpos.copy()
    mujoco.mj_step(model, data, 1000)
    assert abs(data.qvel).max() < 1e-9
    assert data.qpos == pytest.approx(place, abs=1e-9)


@pytest.mark.parametrize("joint_damping", [0.0, 4.0])
@pytest.mark.parametrize("damping", [0.0, 0.5])
@pytest.mark.parametrize(("share", "is_warned"), [(0.9, False), (1.1, True)])
def test_cables_are_warned_of_where_a_step_makes_them_ring(
    joint_damping, damping, share, is_warned
):
    """Guides that hold; ``damping`` is over stiffness times step."""
    spec, step = drum(damping=joint_damping), 1e-3
    inertia = float(spec.compile().dof_M0[0]) + 0.5 * step * joint_damping
    guides = len(view_of(spec, friction=1.0).slip)
    largest = share * 4.0 / step**2 * inertia / (2.0 * RADIUS**2 * 2 * guides / LENGTH)
    ea = largest / (1.0 + 2.0 * damping)
    cable = MOTOR | {"friction": 1.0, "axial_stiffness": ea, "axial_damping": damping * ea * step}
    with pytest.warns(TendonWarning, match="joint 'j'") if is_warned else silent(TendonWarning):
        model = add_cable_drive(spec, "m", **cable, armature=1.0, pretension=1e-4 * ea).compile()
    data = mujoco.MjData(model)
    data.qvel[0] = 1e-6
    mujoco.mj_step(model, data, 200)
    assert (abs(data.qvel[0]) > 1e-4) == is_warned


def view_of(spec, **cable):
    model = add_cable_drive(spec.copy(), "m", **MOTOR | {"armature": 1.0} | cable).compile()
    return view_sheath(model, mujoco.MjData(model), "j_cable")


def geared_hand():
    """A hand with each kind of actuator that depends on its joint, in degrees, and keyframes."""
    spec = hand()
    spec.delete(spec.actuator("curl"))
    spec.joint("pip").ref, spec.joint("pip").armature = 10.0, 3e-3
    for name, joint in (("pip", "pip"), ("more", "pip")):
        actuator = spec.add_actuator(
            name=name, target=joint, trntype=mujoco.mjtTrn.mjTRN_JOINTINPARENT
        )
        actuator.set_to_position(kp=2.0, dampratio=1.0)
    spec.joint("mcp").actfrcrange = [-1.0, 1.0]
    return spec


def test_what_was_added_goes_without_a_trace_and_keyframes_have_motors_meanwhile():
    stock, spec = geared_hand(), geared_hand()
    for one in (stock, spec):
        one.keys[0].qvel = [1.0, 2.0, 3.0]
    stock = stock.compile()
    with pytest.warns(TendonWarning, match="actuatorfrcrange of joint 'mcp_motor'"):
        model = add_cable_drive(spec, "*", **MOTOR | {"armature": 1e-3}, efficiency=0.8).compile()
    assert [model.joint(k).name for k in range(3)] == ["mcp", "pip", "dip"]
    assert model.key_qpos[0] == pytest.approx([0.1, 0.2, 0.3, 0.1, 0.2])
    assert model.key_qvel[0] == pytest.approx([1.0, 2.0, 3.0, 1.0, 2.0])
    assert model.qpos0[[1, 4]] == pytest.approx(math.radians(10.0))
    assert model.actuator_biasprm == pytest.approx(stock.actuator_biasprm)
    assert model.dof_armature == pytest.approx([0.0, 2e-3, 0.0, 1e-3, 1e-3])
    assert_equal(remove_friction(spec, "*").compile(), stock)


@pytest.mark.parametrize("more", ["", 'dampratio="1"'])
def test_a_file_with_motors_is_the_model(more, tmp_path):
    source, written = tmp_path / "hand.xml", tmp_path / "hand_mu.xml"
    source.write_text(
        f"""<mujoco><default><joint damping=".1" limited="true" margin=".01"/></default>
        <worldbody><body><joint name="j" range="-30 90" ref="10" armature=".002"/>
        <geom size=".02"/></body></worldbody>
        <actuator><position name="m" joint="j" kp="1" inheritrange="1" {more}/></actuator>
        <keyframe><key qpos=".3"/></keyframe></mujoco>"""
    )
    spec = mujoco.MjSpec.from_file(str(source))
    attach_cable_drives(spec, source, "*", written, **MOTOR, efficiency=0.8)
    again = mujoco.MjSpec.from_file(str(written))
    assert again.compile().key_qpos[0] == pytest.approx([0.3, 0.3])
    stock = mujoco.MjModel.from_xml_path(str(source))
    assert_equal(remove_friction(again, "*").compile(), stock)


def bounded():
    spec = drum()
    spec.compiler.boundinertia = 1e-3
    return spec


def motored():
    return add_cable_drive(drum(), "m", **MOTOR, armature=1e-3)


@pytest.mark.parametrize(
    ("call", "facts"),
    [
        (lambda: add_cable_drive(drum(), "m", **CABLE, motor=True), "axial_stiffness [N]"),
        (lambda: add_cable_drive(drum(), "m", **MOTOR | {"length": None}), "length [m]"),
        (lambda: add_cable_drive(drum(), "m", **MOTOR), "'j' has no armature | armature [kg m²]"),
        (lambda: add_cable_drive(drum(), "m", **MOTOR, armature=-1.0), "armature = -1 [kg m²]"),
        (
            lambda: add_cable_drive(drum(), "m", **CABLE, axial_stiffness=1e4),
            "'axial_stiffness' = 10000 | motor=True",
        ),
        (lambda: add_cable_drive(hand(), "curl", **MOTOR, armature=1e-3), "'curl' | fixed tendon"),
        (lambda: add_cable_drive(motored(), "m", **CABLE), "has a cable already"),
        (lambda: add_cable_drive(bounded(), "m", **MOTOR, armature=1e-3), "boundinertia = 0.001"),
        (lambda: remove_friction(motored(), "j_cable"), "'j_cable', 'j_cable_back' | all"),
        (lambda: remove_friction(motored(), "j_cable_back"), "'j_cable', 'j_cable_back' | all"),
        (lambda: add_cable_drive(drum(), "m", **CABLE, efficiency=0.0), "efficiency = 0"),
        (lambda: add_cable_drive(drum(), "m", **CABLE, back_efficiency=1.0), "back_efficiency = 1"),
    ],
)
def test_a_refusal_names_the_way_out(call, facts):
    with refusing(TendonError, facts):
        call()


def test_a_sensor_of_actuators_that_have_left_its_joint_is_warned_of():
    spec = drum()
    spec.add_sensor(
        name="torque", type=mujoco.mjtSensor.mjSENS_JOINTACTFRC,
        objtype=mujoco.mjtObj.mjOBJ_JOINT, objname="j",
    )  # fmt: skip
    with pytest.warns(TendonWarning, match="'torque'"):
        add_cable_drive(spec, "m", **MOTOR, armature=1e-3)


def test_a_muscle_keeps_its_length_range_on_a_motor():
    """Which MuJoCo finds by pulling it to its joint's limits, and a motor has none."""
    spec = mujoco.MjSpec.from_string("""<mujoco><worldbody><body>
        <joint name="j" armature=".002" damping=".1" range="-60 60"/><geom size=".02"/></body>
        </worldbody><actuator><muscle name="m" joint="j" force="5"/></actuator></mujoco>""")
    stock = spec.compile()
    behind = add_cable_drive(spec, "m", **MOTOR, armature=1e-3).compile()
    assert behind.actuator_lengthrange == pytest.approx(stock.actuator_lengthrange)


@pytest.mark.parametrize("damping", [{}, {"axial_damping": 5.0}])
def test_the_step_that_a_warning_names_carries_the_cables(damping):
    """A joint with damping has less inertia in a shorter step."""
    cable = MOTOR | {"armature": 5e-4, "pretension": PRETENSION, **damping}

    def said(step):
        spec = servoed(armature=1e-3)
        spec.option.timestep, spec.joint("j").damping[0] = step, 0.5
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            add_cable_drive(spec, "m", **cable)
        return " ".join(str(each.message) for each in caught)

    named = re.search(r"or a step of ([\d.e-]+) s", said(0.02))
    assert named is not None
    assert "a step of" not in said(float(named[1]))
    assert "a step of" in said(1.3 * float(named[1]))
