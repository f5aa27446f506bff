"""Servos of BAM, against its equations: bam/model.py, actuator.py and simulate.py of Rhoban/bam."""

import json
import math

import mujoco
import numpy as np
import pytest

from tendon_mj import add_cable_drive, remove_friction, view_sheath
from tests.attach.test_cable_drive import HAND
from tests.attach.test_motor import SLOW
from tests.refusals import refusing

# Older ones are refused, with the release that does.
pytestmark = pytest.mark.skipif(
    not hasattr(mujoco, "mjtCtrlInput"), reason="DC motors that are controlled by angles"
)

# bam/params/mx106, to four digits
MX106 = {
    "m1": {
        **{"kt": 2.191, "R": 2.965, "armature": 0.02661, "friction_base": 0.1035},
        **{"friction_viscous": 0.0352},
    },
    "m4": {
        **{"kt": 2.231, "R": 2.372, "armature": 0.02457, "friction_base": 6.653e-13},
        **{"friction_stribeck": 0.1049, "load_friction_base": 0.00915},
        **{"load_friction_stribeck": 0.2224, "dtheta_stribeck": 1.623, "alpha": 1.323},
        **{"friction_viscous": 0.05096},
    },
    "m6": {
        **{"kt": 2.21, "R": 2.034, "armature": 0.02602, "friction_base": 1.023e-05},
        **{"friction_stribeck": 0.122, "load_friction_motor": 0.198},
        **{"load_friction_external": 0.02222, "load_friction_motor_stribeck": 0.1986},
        **{"load_friction_external_stribeck": 0.0871, "load_friction_motor_quad": 0.01},
        **{"load_friction_external_quad": 7.327e-05, "dtheta_stribeck": 1.746, "alpha": 1.143},
        **{"friction_viscous": 0.05072},
    },
}
GAIN, VOLTAGE = 15.0 * 32.0 * 0.158, 0.9625 * 15.0  # of its firmware, bam/dynamixel/actuator.py
MASS, ROD, LENGTH, GRAVITY = 1.0, 0.05, 0.15, 9.80665  # of the pendulum
INERTIA = (MASS + ROD / 3.0) * LENGTH**2
MOMENT = (MASS + 0.5 * ROD) * LENGTH
NO_CABLE = {"radius": 1.0, "bend": 1.0, "friction": 0.0}
PENDULUM = f"""
<mujoco>
  <option timestep=".0005" gravity="0 0 {-GRAVITY}"/>
  <worldbody><body><joint name="j" axis="0 -1 0" armature=".1" damping="1" frictionloss="1"/>
    <inertial pos="0 0 {-MOMENT / (MASS + ROD)}" mass="{MASS + ROD}"
     diaginertia=".1 {INERTIA - MOMENT**2 / (MASS + ROD)} .1"/>
  </body></worldbody>
  <actuator><{{}} name="m" joint="j"/></actuator>
</mujoco>
"""


def written(folder, name, **changes):
    """The file of a model with changed numbers; those that are None are left out."""
    numbers = {"model": name, "actuator": "mx106"} | MX106[name] | changes
    path = folder / f"{name}.json"
    path.write_text(json.dumps({k: v for k, v in numbers.items() if v is not None}))
    return path


def servo(path, spec=None, actuator="position", **more):
    """A pendulum, or another model, whose actuators are servos, and its data."""
    spec = spec or mujoco.MjSpec.from_string(PENDULUM.format(actuator))
    model = add_cable_drive(spec, "*", **NO_CABLE | {"servo": path} | more).compile()
    return model, mujoco.MjData(model)


def largest_friction(numbers, motor, load, speed):
    """BAM's budget of dry friction."""

    def on_gearbox(name):
        both = numbers.get(f"load_friction_{name or 'base'}", 0.0)
        tail = f"_{name}" if name else ""
        external = numbers.get(f"load_friction_external{tail}", both)
        return abs(external * load - numbers.get(f"load_friction_motor{tail}", both) * motor)

    budget = numbers["friction_base"] + on_gearbox("")
    if "alpha" not in numbers:
        return budget
    held = numbers["friction_stribeck"] + on_gearbox("stribeck")
    if np.sign(load) != np.sign(motor):
        if abs(load) < abs(motor):
            held += numbers.get("load_friction_external_quad", 0.0) * load**2
        elif abs(load) > abs(motor):
            held += numbers.get("load_friction_motor_quad", 0.0) * motor**2
    fades = (abs(speed) / numbers["dtheta_stribeck"]) ** numbers["alpha"]
    return budget + held * math.exp(-fades)


def target(t):
    """A command that turns back at ever other loads."""
    return 1.4 * math.sin(2.0 * t) * math.sin(t * t)


def simulated(numbers, steps, h):
    """Angles of BAM's pendulum by its own method."""
    q = v = 0.0
    angles = []
    inertia = INERTIA + numbers["armature"]
    for k in range(steps):
        angles.append(q)
        voltage = np.clip(GAIN * (target(k * h) - q), -VOLTAGE, VOLTAGE)
        motor = numbers["kt"] / numbers["R"] * (voltage - numbers["kt"] * v)
        load = -MOMENT * GRAVITY * math.sin(q)
        most = largest_friction(numbers, motor, load, v) + numbers["friction_viscous"] * abs(v)
        stop = inertia / h * v + motor + load
        v += h * (motor + load - np.sign(stop) * min(abs(stop), most)) / inertia
        q += h * v
    return np.array(angles)


@pytest.mark.parametrize("name", MX106)
def test_its_pendulum_moves_as_its_own_simulation(name, tmp_path):
    model, data = servo(written(tmp_path, name), servo_gain=GAIN, servo_voltage=VOLTAGE)
    h, angles = model.opt.timestep, []
    for k in range(8000):
        angles.append(data.qpos[0])
        data.ctrl[0] = target(k * h)
        mujoco.mj_step(model, data)
    expected = simulated(MX106[name], 8000, h)
    motion = np.ptp(expected)
    assert abs(angles - expected).max() < 1e-3 * motion
    free = {k: 0.0 if "friction" in k else v for k, v in MX106[name].items()}
    assert abs(angles - simulated(free, 8000, h)).max() > 5e-3 * motion


@pytest.mark.parametrize("name", ["m1", "m4", "m6"])
def test_its_friction_under_any_torques_is_its_budget(name, tmp_path):
    rng = np.random.default_rng(3)
    for _ in range(40):
        numbers = {k: v if k == "model" else rng.uniform(0.1, 1.0) for k, v in MX106[name].items()}
        model, data = servo(written(tmp_path, name, **numbers), actuator="motor")
        model.opt.gravity[:] = 0.0
        motor, load, data.qvel[0] = rng.normal(size=3)
        data.qvel[0] += 5.0 * np.sign(data.qvel[0])  # which no friction ends in a step
        data.ctrl[0], data.qfrc_applied[0] = motor, load
        speed = data.qvel[0]
        mujoco.mj_step(model, data)
        view = view_sheath(model, data, "j_cable")
        friction = view.output_tension - view.input_tension
        expected = -np.sign(speed) * largest_friction(numbers, motor, load, speed)
        assert friction == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize("integrator", range(4))
def test_it_rests_under_any_load_and_takes_energy_alone(integrator, tmp_path):
    rng = np.random.default_rng(integrator)
    path = written(tmp_path, "m6")
    model, data = servo(path, servo_gain=GAIN, servo_voltage=VOLTAGE)
    model.opt.integrator, model.opt.timestep = integrator, 0.002
    view = view_sheath(model, data, "j_cable")
    given = taken = 0.0
    for _ in range(10):
        data.ctrl[0] = rng.uniform(-1.5, 1.5)
        for _ in range(1000):
            mujoco.mj_step(model, data)
            work = (view.output_tension - view.input_tension) * data.qvel[0]
            given, taken = given + max(0.0, work), taken + max(0.0, -work)
        assert abs(data.qvel[0]) < 1e-12
    assert given < 1e-5 * taken


def test_a_joint_has_the_servo_s_inertia_and_damping_alone(tmp_path):
    model, _ = servo(written(tmp_path, "m6", q_offset=0.1))
    found = model.dof_armature[0], model.dof_damping[0], model.dof_frictionloss[0]
    assert found == (0.02602, 0.05072, 0.0)
    assert model.actuator("m").gaintype == mujoco.mjtGain.mjGAIN_FIXED  # as it was


@pytest.mark.parametrize(("kind", "limits"), [("position", 1.0), ("motor", 0.0)])
def test_a_range_of_controls_stays_if_they_were_angles(kind, limits, tmp_path):
    more = 'inheritrange="1"' if kind == "position" else 'ctrlrange="-3 3"'
    spec = mujoco.MjSpec.from_string(PENDULUM.format(f"{kind} {more}"))
    spec.joint("j").range = [-180.0 / math.pi, 180.0 / math.pi]
    path = written(tmp_path, "m1")
    model, data = servo(path, spec, servo_gain=4.0, servo_voltage=VOLTAGE)
    data.ctrl[0] = 1.5
    mujoco.mj_forward(model, data)
    torque = MX106["m1"]["kt"] / MX106["m1"]["R"] * 4.0 * (limits or 1.5)
    assert data.actuator_force[0] == pytest.approx(torque)


def test_a_motor_is_the_servo_and_leaves_its_numbers_to_the_joint(tmp_path):
    spec = mujoco.MjSpec.from_string(PENDULUM.format("position"))
    path = written(tmp_path, "m6")
    cables = SLOW | {"armature": None, "axial_stiffness": 1e4, "axial_damping": 100.0}
    model, data = servo(path, spec, servo_gain=GAIN, servo_voltage=VOLTAGE, **cables)
    joint, motor = model.joint("j").dofadr[0], model.joint("j_motor").dofadr[0]
    assert model.dof_armature[[joint, motor]].tolist() == [0.0, 0.02602]
    assert model.dof_damping[[joint, motor]].tolist() == [0.0, 0.05072]
    assert model.dof_frictionloss[[joint, motor]].tolist() == [0.0, 0.0]
    data.ctrl[0] = 0.5
    mujoco.mj_step(model, data, 5000)
    view = view_sheath(model, data, "j_gear")
    torque = view.output_tension * SLOW["radius"]
    assert torque == pytest.approx(GRAVITY * MOMENT * math.sin(data.qpos[joint]), rel=1e-3)
    assert view.input_tension != pytest.approx(view.output_tension, rel=1e-3)
    model = remove_friction(spec, "*").compile()
    assert (model.nv, model.dof_armature[0], model.dof_damping[0]) == (1, 0.02602, 0.05072)


@pytest.mark.parametrize(
    ("changes", "facts"),
    [
        ({"model": "m7"}, "m7 | m1, m2"),
        ({"alpha": None}, "lacks alpha"),
        ({"current_limit": 1.5}, "current_limit | actuator"),
        ({"alpha": 0.0}, "alpha | 0"),
        ({"friction_base": -0.1}, "friction_base | -0.1"),
        ({"armature": "x"}, "armature | 'x'"),
        ({"R": None}, "R = 0 | servo_gain"),
        ({"kt": -1.0}, "kt = -1"),
    ],
)
def test_a_file_that_is_not_one_of_its_models_is_refused(changes, facts, tmp_path):
    path = written(tmp_path, "m6", **changes)
    with refusing(ValueError, "m6.json", facts):
        servo(path, servo_gain=GAIN, servo_voltage=VOLTAGE)


@pytest.mark.parametrize(
    ("given", "facts"),
    [
        ({"efficiency": 0.9}, "efficiency | m6.json"),
        ({"servo": None, "servo_gain": 5.0}, "servo_gain = 5 | servo"),
        ({"servo_gain": 5.0}, "servo_voltage = 0"),
        ({"servo": "none.json"}, "none.json | read"),
    ],
)
def test_what_does_not_go_with_a_servo_is_refused(given, facts, tmp_path):
    spec = mujoco.MjSpec.from_string(PENDULUM.format("motor"))
    before = spec.to_xml()
    with refusing(ValueError, facts):
        servo(written(tmp_path, "m6"), spec, **given)
    assert spec.to_xml() == before


def test_a_servo_is_at_one_joint_whose_numbers_are_its_own(tmp_path):
    path = written(tmp_path, "m6")
    hand = mujoco.MjSpec.from_string(
        HAND.format(integrator="Euler", gravity=0, damping=0, unit=1, gear=1)
    )
    with refusing(ValueError, "curl | fixed tendon"):
        add_cable_drive(hand, "curl", **NO_CABLE, servo=path)
    spec = mujoco.MjSpec.from_string(PENDULUM.format('motor gear="50"'))
    with refusing(ValueError, "'m' | gear = 50"):
        servo(path, spec, servo_gain=GAIN, servo_voltage=VOLTAGE)
