"""Gears between actuators and cables that are not drawn, whose friction grows with their load."""

import math

import mujoco
import numpy as np
import pytest

from tendon_mj import Parameters, add_cable_drive, view_sheath
from tests.attach.test_cable_drive import CABLE, EXPONENT, RADIUS, drum
from tests.attach.test_motor import SLOW, servoed
from tests.refusals import refusing
from tests.rigs import sheath

# no joint here meets a contact, a limit or an equality
pytestmark = pytest.mark.filterwarnings("ignore:add_cable_drive. a gear with a back efficiency")
FREE = CABLE | {"friction": 0.0}  # cables that lose nothing


def geared(efficiency, back=None, spec=None, **cable):
    """A model with a gear, its data, and a view of its cable."""
    gear = {"efficiency": efficiency, "back_efficiency": back}
    model = add_cable_drive(spec or drum(), "m", **FREE | cable, **gear).compile()
    data = mujoco.MjData(model)
    return model, data, view_sheath(model, data, "j_gear" if "motor" in cable else "j_cable")


def passed_on(model, data, view, torque, load, steps=300):
    """Tensions in front of a gear and behind it, and the speed of the joint."""
    data.ctrl[0], data.qfrc_applied[0] = torque, load
    mujoco.mj_step(model, data, steps)
    return view.input_tension, view.output_tension, data.qvel[0]


@pytest.mark.parametrize("way", [1.0, -1.0])
@pytest.mark.parametrize(
    ("efficiency", "back"), [(0.9, None), (0.6, None), (0.8, 0.3), (0.7, 0.95)]
)
def test_a_gear_passes_on_what_is_stated_forward_and_back(efficiency, back, way):
    rig = geared(efficiency, back)
    given, arrived, speed = passed_on(*rig, 0.5 * way, 0.0)
    assert way * speed > 0.0
    assert arrived / given == pytest.approx(efficiency, abs=1e-9)
    held, pulled, speed = passed_on(*rig, 0.5 * way, -5.0 * way)
    assert way * speed < 0.0
    expected = 2.0 - 1.0 / efficiency if back is None else back
    assert held / pulled == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize("efficiency", [0.9, 0.5, 0.4])
@pytest.mark.parametrize("way", [1.0, -1.0])
def test_it_holds_any_load_between_and_is_stuck(efficiency, way):
    back = 2.0 - 1.0 / efficiency
    most = 1.0 / back if back > 0.0 else 50.0
    for share in (0.01, 0.5, 0.99):
        load = efficiency + share * (most - efficiency)
        rig = geared(efficiency)
        data = rig[1]
        passed_on(*rig, 0.5 * way, -0.5 * way * load, 1000)
        place = data.qpos[0]
        _, arrived, speed = passed_on(*rig, 0.5 * way, -0.5 * way * load, 1000)
        assert abs(speed) < 1e-12
        assert data.qpos[0] == pytest.approx(place, abs=1e-12)
        assert way * arrived == pytest.approx(0.5 * load / RADIUS, rel=1e-9)


@pytest.mark.parametrize("way", [1.0, -1.0])
@pytest.mark.parametrize(("efficiency", "locks"), [(0.51, False), (0.49, True)])
def test_below_a_half_no_load_turns_a_motor_that_is_off(efficiency, locks, way):
    rig = geared(efficiency)
    passed_on(*rig, 0.5 * way, 0.0)
    *_, speed = passed_on(*rig, 0.0, -5.0 * way, 500)
    assert (abs(speed) < 1e-12) == locks


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_a_gear_that_locks_itself_lowers_a_load_where_the_motor_turns_it_down(way):
    """η_b = −0.5: the motor has to give half of the load."""
    rig = geared(0.4)
    passed_on(*rig, 0.5 * way, -5.0 * way)
    for torque in (-0.1, -2.4):
        *_, speed = passed_on(*rig, torque * way, -5.0 * way)
        assert abs(speed) < 1e-12
    given, arrived, speed = passed_on(*rig, -2.6 * way, -5.0 * way)
    assert way * speed < 0.0
    assert arrived / given == pytest.approx(0.4, abs=1e-9)
    *_, speed = passed_on(*rig, 0.0, -5.0 * way)
    assert abs(speed) < 1e-12


@pytest.mark.parametrize(("torque", "holds"), [(-1e-3, True), (-0.05, True), (-0.16, False)])
def test_it_holds_a_load_that_comes_on_with_the_motor_s_torque(torque, holds):
    """η_b = −0.5: of 0.3 N m, the motor has to give 0.15."""
    cables = {"motor": True, "armature": 1e-3, "axial_stiffness": 3e3, "length": 0.3}
    law = {"friction": 1e-9, "pretension": 40.0, "efficiency": 0.4}
    model = add_cable_drive(drum(damping=0.02), "m", **CABLE | law | cables).compile()
    data = mujoco.MjData(model)
    for k in range(2000):
        grown = min(1.0, k / 300)
        data.ctrl[0], data.qfrc_applied[0] = torque * grown, -0.3 * grown
        mujoco.mj_step(model, data)
    assert (np.abs(data.qvel) < 1e-6).all() == holds


@pytest.mark.parametrize("way", [1.0, -1.0])
@pytest.mark.parametrize("part", [0.0, 0.9, 0.99])
def test_a_motion_that_load_and_motor_brake_ends_at_once_and_a_held_one_stays(part, way):
    """η_b = −0.5, and the motor gives a part of the half that would lower the load."""
    model, data, view = geared(0.4, spec=drum(damping=0.0))
    data.qvel[0] = way
    *_, speed = passed_on(model, data, view, -way * part * 0.15, -0.3 * way, 1)
    assert abs(speed) < 1e-12
    *_, speed = passed_on(model, data, view, -way * part * 0.15, -0.3 * way)
    assert abs(speed) < 1e-12
    assert abs(data.qpos[0]) < 1e-12
    assert view.friction_work.sum() < 1e-12


@pytest.mark.parametrize("pretension", [0.0, 2.0])
def test_cables_lose_from_what_their_gear_passes_on(pretension):
    rig = geared(0.8, friction=CABLE["friction"], pretension=pretension)
    given, arrived, speed = passed_on(*rig, 0.05, 0.0)
    behind = 0.8 * given
    lost = max(2.0 * pretension * EXPONENT, -behind * math.expm1(-EXPONENT))
    assert speed > 0.0
    assert arrived == pytest.approx(behind - lost, rel=1e-9)
    held, pulled, speed = passed_on(*rig, 0.05, -0.5)
    driven = held / 0.75
    lost = max(2.0 * pretension * EXPONENT, driven * math.expm1(EXPONENT))
    assert speed < 0.0
    assert pulled == pytest.approx(driven + lost, rel=1e-9)


@pytest.mark.parametrize("efficiency", [0.8, 0.4])
@pytest.mark.parametrize("seed", range(3))
def test_a_gear_takes_energy_and_gives_none(efficiency, seed):
    rng, spec = np.random.default_rng(seed), servoed(kp=3.0, stiffness=0.5)
    spec.actuator("m").biasprm[2] = -0.05
    model, data, view = geared(efficiency, spec=spec)
    lost = 0.0
    for _ in range(3000):
        if rng.random() < 0.01:
            data.ctrl[0], data.qfrc_applied[0] = rng.normal(), rng.normal()
        before = data.qvel[0]
        mujoco.mj_step(model, data)
        friction = RADIUS * (view.output_tension - view.input_tension)
        lost -= friction * 0.5 * (before + data.qvel[0]) * model.opt.timestep
        assert lost > -1e-4
    assert lost > 0.1


def test_a_motor_has_its_gear_in_front_of_its_joint():
    model, data, view = geared(0.8, **SLOW)
    assert model.tendon(model.ntendon - 1).name == "j_gear"
    for torque in (0.3, -0.3):
        data.ctrl[0] = torque
        mujoco.mj_step(model, data, 500)
        assert torque * data.qvel[1] > 0.0
        assert view.input_tension == pytest.approx(torque / RADIUS)
        assert view.output_tension == pytest.approx(0.8 * torque / RADIUS, rel=1e-9)


def test_its_friction_is_live_and_not_that_of_a_tendon_that_is_drawn():
    rig = geared(0.8)
    Parameters(*rig[:2])["j_cable.gear_friction"] = 1.0
    given, arrived, _ = passed_on(*rig, 0.5, 0.0)
    assert arrived / given == pytest.approx(0.5)
    with refusing(ValueError, "gear_friction = 0.5 | drawn"):
        mujoco.MjModel.from_xml_string(
            f"""<mujoco>{sheath(tendon="t", friction=0.1, gear_friction=0.5, axial_stiffness=1e4)}
            <worldbody><site name="a"/><body><joint type="slide"/><geom size=".1"/>
            <site name="b" pos="1 0 0"/></body></worldbody>
            <tendon><spatial name="t"><site site="a"/><site site="b"/></spatial></tendon>
            </mujoco>"""
        )


@pytest.mark.parametrize("efficiency", [0.8, 0.4])
@pytest.mark.parametrize("speed", [2.0, -2.0])
def test_inverse_dynamics_knows_what_a_gear_bears(efficiency, speed):
    rig = geared(efficiency)
    passed_on(*rig, 0.5, -0.3, 20)
    model, data = rig[:2]
    mujoco.mj_forward(model, data)
    mujoco.mj_inverse(model, data)
    applied = data.qfrc_applied + data.qfrc_actuator
    assert data.qfrc_inverse == pytest.approx(applied, abs=1e-9)
    data.qvel[0] = speed
    mujoco.mj_inverse(model, data)
    assert np.isfinite(data.qfrc_inverse).all()


@pytest.mark.parametrize("efficiency", [0.5, 0.51])
def test_a_gear_that_locks_itself_is_warned_of_unless_it_has_a_motor(efficiency, recwarn):
    geared(efficiency)
    geared(efficiency, **SLOW)
    told = [str(w.message) for w in recwarn if "locks itself" in str(w.message)]
    assert len(told) == (efficiency <= 0.5)
    assert all("give motor=True" in text for text in told)
