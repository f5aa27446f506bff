"""A driven tendon comes to rest at the model's own step: friction holds, and makes no energy."""

import mujoco
import numpy as np
import pytest

from tendon_mj import add_friction, largest_stiffness, view_sheath

STEP = 2e-3
SPRING, DAMPER = 60.0, 1.0  # of the carriage [N/m, N s/m]
# a carriage on a spring, pulled over two quarter turns
CARRIAGE = """
<mujoco>
  <option timestep="{step}" gravity="0 0 0"/>
  <worldbody>
    <site name="a" pos="0 0 .1"/><site name="b" pos="0 0 0"/>
    <site name="c" pos=".1 0 0"/><site name="d" pos=".1 0 -.1"/>
    <body pos=".1 0 -.3">
      <joint name="z" type="slide" axis="0 0 1" stiffness="{spring}" damping="{damper}"/>
      <geom size=".01" mass="{mass}"/><site name="e"/>
    </body>
  </worldbody>
  <tendon><spatial name="t"><site site="a"/><site site="b"/><site site="c"/><site site="d"/>
    <site site="e"/></spatial></tendon>
  <actuator><motor tendon="t"/></actuator>
</mujoco>
"""
MASSES = [1.0, 0.2, 0.05, 0.01]
STIFFNESSES = [None, 2e3, 1e5, 1e7]


def carriage(mass, stiffness, step=STEP):
    text = CARRIAGE.format(step=step, spring=SPRING, damper=DAMPER, mass=mass)
    spec = mujoco.MjSpec.from_string(text)
    return add_friction(spec, "t", friction=0.3, axial_stiffness=stiffness, sensors=()).compile()


@pytest.mark.parametrize("mass", MASSES)
@pytest.mark.parametrize("stiffness", STIFFNESSES)
def test_no_energy_is_made(mass, stiffness):
    model = carriage(mass, stiffness)
    data = mujoco.MjData(model)
    data.ctrl[0] = -6.0
    mujoco.mj_forward(model, data)
    length, damped = data.ten_length[0], 0.0
    for _ in range(1000):
        mujoco.mj_step(model, data)
        damped += DAMPER * data.qvel[0] ** 2 * STEP
    mujoco.mj_fwdPosition(model, data)
    work = 6.0 * (length - data.ten_length[0])
    kept = 0.5 * mass * data.qvel[0] ** 2 + 0.5 * SPRING * data.qpos[0] ** 2
    rubbed = view_sheath(model, data, "t").friction_work.sum()
    assert kept + damped + rubbed == pytest.approx(work, rel=0.02)


@pytest.mark.parametrize("mass", MASSES[1:])  # the heaviest still swings
@pytest.mark.parametrize("stiffness", STIFFNESSES)
def test_friction_holds(mass, stiffness):
    model = carriage(mass, stiffness)
    data = mujoco.MjData(model)
    data.ctrl[0] = -6.0
    mujoco.mj_step(model, data, 1500)
    held = []
    for _ in range(20):
        mujoco.mj_step(model, data)
        held.append((float(view_sheath(model, data, "t").output_tension), data.qpos[0]))
    assert np.ptp(held, axis=0) == pytest.approx([0.0, 0.0], abs=0.01)


@pytest.mark.parametrize("mass", MASSES)
def test_it_comes_to_rest_where_a_finer_step_says(mass):
    assert largest_stiffness(carriage(mass, None), "t") < 1e5

    def motion(parts):
        model = carriage(mass, None, STEP / parts)
        data = mujoco.MjData(model)
        data.ctrl[0] = -6.0
        positions = []
        for _ in range(500):
            mujoco.mj_step(model, data, parts)
            positions.append(data.qpos[0])
        return np.array(positions), view_sheath(model, data, "t").friction_work.sum()

    (own, rubbed), (fine, finely) = motion(1), motion(16)
    assert np.abs(own - fine).max() < 0.15 * np.ptp(fine)  # of the integrator
    assert abs(own[-1] - fine[-1]) < 0.02 * np.ptp(fine)
    assert rubbed == pytest.approx(finely, rel=0.03)
