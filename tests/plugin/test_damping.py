"""Axial damping: T = EA ε + c dε/dt."""

import mujoco
import numpy as np
import pytest

from tests.plugin.rigs import arm, elastic_energy, run, snapshot, started, unsigned

STRING = """
<mujoco>
  <option gravity="0 0 0" timestep="{timestep}" integrator="{integrator}"/>
  <extension><plugin plugin="tendon_mj.sheath"><instance name="sheath">
    <config key="tendon" value="tendon"/><config key="axial_stiffness" value="1000"/>
    <config key="friction" value="0"/><config key="pretension" value="100"/>
    <config key="axial_damping" value="{damping}"/>
  </instance></plugin></extension>
  <worldbody>
    <site name="a"/>
    <body pos="1 0 0"><joint name="x" type="slide" axis="1 0 0" springref="{ref}" stiffness="500"/>
      <geom size=".1" mass="2" contype="0"/><site name="b"/></body>
  </worldbody>
  <tendon><spatial name="tendon"><site site="a"/><site site="b"/></spatial></tendon>
</mujoco>
"""


def swing(damping, timestep, integrator="Euler"):
    """Displacements of a mass on a tendon without guides, balanced by a spring, over 1 s."""
    xml = STRING.format(damping=damping, timestep=timestep, integrator=integrator, ref=0.2)
    model = mujoco.MjModel.from_xml_string(xml)
    data = mujoco.MjData(model)
    data.qpos[0] = 1e-3
    path = []
    for _ in range(round(1.0 / timestep)):
        path.append(data.qpos[0])
        mujoco.mj_step(model, data)
    return np.array(path)


def exact(damping, timestep):
    """Free oscillation with k = EA/S + k_spring and c/S about the balance."""
    unstretched, mass = 1.0 / (1.0 + 100.0 / 1000.0), 2.0
    stiffness, friction = 1000.0 / unstretched + 500.0, damping / unstretched
    decay = friction / (2 * mass)
    omega = np.sqrt(stiffness / mass - decay**2)
    time = timestep * np.arange(round(1.0 / timestep))
    wave = np.cos(omega * time) + decay / omega * np.sin(omega * time)
    return 1e-3 * np.exp(-decay * time) * wave


@pytest.mark.parametrize("damping", [2.0, 10.0])
@pytest.mark.parametrize("integrator", ["Euler", "RK4"])
def test_a_mass_on_a_tendon_decays_as_it_must(damping, integrator):
    errors = [
        np.abs(swing(damping, h, integrator) - exact(damping, h)).max() / 1e-3
        for h in (5e-4, 2.5e-4, 1.25e-4)
    ]
    assert errors[2] < 2e-2
    assert errors[2] < 0.6 * errors[1] < 0.36 * errors[0]


def test_no_damping_is_as_if_the_word_were_not_there():
    for integrator in ("Euler", "RK4"):
        without, zero = arm(integrator=integrator), arm(integrator=integrator, axial_damping=0.0)
        one, other = (run(m, started(m, 2, 2.0), 300) for m in (without, zero))
        actual, expected = snapshot(without, one), snapshot(zero, other)
        np.testing.assert_array_equal(unsigned(actual), unsigned(expected))


@pytest.mark.parametrize("seed", range(4))
def test_damping_takes_energy_and_gives_none(seed):
    ends = []
    for damping in (0.0, 1.0, 4.0):
        model = arm(axial_damping=damping, friction=0.0, timestep=1e-4)
        data = started(model, seed, 1.0)
        data.qvel[:] += 1.0
        mujoco.mj_forward(model, data)
        start = data.energy.sum() + elastic_energy(model, data, 500.0)
        run(model, data, 3000)
        mujoco.mj_forward(model, data)
        mujoco.mj_energyPos(model, data)
        tension = data.sensor("tension").data.copy()
        # with damping the sensor shows more than the spring, so measure the strain itself
        points = data.site_xpos[model.wrap_objid]
        length = np.linalg.norm(np.diff(points, axis=0), axis=1).sum()
        unstretched = float(model.tendon_length0[0]) / (1.0 + 8.0 / 500.0)
        strain = max(0.0, length / unstretched - 1.0)
        stored = 0.5 * 500.0 * strain**2 * unstretched
        ends.append(data.energy.sum() + stored - start)
        assert np.all(tension >= 0.0)
    assert abs(ends[0]) < 5e-3
    assert ends[2] < ends[1] < ends[0]
    assert ends[1] < -1e-3
