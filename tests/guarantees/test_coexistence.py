"""A sheath beside MuJoCo's own plugins and a user's callbacks."""

import mujoco
import numpy as np
import pytest

from tendon_mj import add_friction
from tests.rigs import MUJOCO, arm, arm_xml, run, snapshot, started

# a cable of MuJoCo's elasticity plugin, far from the arm
CABLE = """
    <composite prefix="rope" type="cable" curve="s 0 0" count="9 1 1" size=".3" initial="none"
        offset="2 0 1">
      <plugin plugin="mujoco.elasticity.cable"><config key="twist" value="1e6"/>
        <config key="bend" value="1e6"/></plugin>
      <geom type="capsule" size=".005" mass=".01"/>
    </composite>
"""
LEVER = """
<mujoco>
  <worldbody>
    <site name="a" pos="-.2 0 .1"/><site name="b" pos="-.1 0 .02"/>
    <body>
      <joint name="j" axis="0 1 0" stiffness="1" damping=".1" armature="1e-3"/>
      <geom type="capsule" fromto="0 0 0 .1 0 0" size=".01" mass=".1"/>
      <site name="c" pos=".02 0 .03"/><site name="d" pos=".08 0 .02"/>
    </body>
  </worldbody>
  <tendon>
    <spatial name="t"><site site="a"/><site site="b"/><site site="c"/><site site="d"/></spatial>
  </tendon>
  <actuator><general name="m" tendon="t" {gain}/></actuator>
</mujoco>
"""
STEPS = 100


@pytest.fixture(autouse=True)
def no_callback_stays():
    yield
    for clear in (
        mujoco.set_mjcb_passive,
        mujoco.set_mjcb_control,
        mujoco.set_mjcb_act_gain,
        mujoco.set_mjcb_act_bias,
        mujoco.set_mjcb_act_dyn,
    ):
        clear(None)


@pytest.mark.skipif(MUJOCO >= (4, 0), reason="MuJoCo 4.0 has no plugin `mujoco.elasticity.cable`")
def test_a_plugin_of_mujocos_own():
    """Neither changes what the other does to its own bodies."""
    both = mujoco.MjModel.from_xml_string(
        arm_xml()
        .replace("</worldbody>", CABLE + "</worldbody>")
        .replace("<extension>", '<extension><plugin plugin="mujoco.elasticity.cable"/>')
    )
    alone = arm()
    data, own = mujoco.MjData(both), mujoco.MjData(alone)
    for _ in range(STEPS):
        mujoco.mj_step(both, data)
        mujoco.mj_step(alone, own)
    np.testing.assert_allclose(data.qpos[: alone.nq], own.qpos, rtol=1e-9)
    np.testing.assert_allclose(data.sensordata, own.sensordata, rtol=1e-9)
    assert np.ptp(data.qpos[alone.nq :]) > 0.0  # the cable sags


def test_a_user_s_passive_force_adds_to_ours():
    """MuJoCo calls it before the plugins, whose forces add to what it sets."""
    model, seen = arm(), []

    def damp(m, d):
        seen.append(d.qfrc_passive - d.qfrc_spring - d.qfrc_damper)
        d.qfrc_passive[:] -= 0.3 * d.qvel

    mujoco.set_mjcb_passive(damp)
    data = run(model, started(model, 3), STEPS)
    mujoco.set_mjcb_passive(None)
    damped = arm()
    damped.dof_damping[:] += 0.3
    damped.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_EULERDAMP
    other = run(damped, started(damped, 3), STEPS)
    np.testing.assert_allclose(data.qpos, other.qpos, rtol=1e-9)
    assert len(seen) >= STEPS
    assert not np.any(seen)


def pulled(gain):
    """A lever that a general actuator pulls through a sheath."""
    spec = mujoco.MjSpec.from_string(LEVER.format(gain=gain))
    return add_friction(spec, "t", friction=0.3).compile()


def test_a_control_callback_is_a_control_that_is_set():
    """Its friction counts from the next step on, so that both come to rest, each as it was held."""
    model = pulled('gainprm="-1"')
    mujoco.set_mjcb_control(lambda m, d: d.ctrl.fill(5.0))
    called = run(model, mujoco.MjData(model), 3000)
    mujoco.set_mjcb_control(None)
    data = mujoco.MjData(model)
    data.ctrl[:] = 5.0
    run(model, data, 3000)
    for ended in (called, data):
        assert abs(ended.qvel[0]) < 1e-6
        assert ended.sensordata[0] == pytest.approx(5.0)  # the input tension
        assert 0.0 < ended.sensordata[1] < 5.0  # and the output's
    np.testing.assert_allclose(called.qpos, data.qpos, rtol=1e-2)


def test_a_gain_of_a_user_s_own_is_rubbed_as_mujocos():
    given, own = pulled('gainprm="-2"'), pulled('gaintype="user"')
    assert own.actuator_gaintype[0] == mujoco.mjtGain.mjGAIN_USER
    data = mujoco.MjData(given)
    data.ctrl[:] = 4.0
    run(given, data, STEPS)
    mujoco.set_mjcb_act_gain(lambda m, d, actuator: -2.0)
    other = mujoco.MjData(own)
    other.ctrl[:] = 4.0
    run(own, other, STEPS)
    np.testing.assert_array_equal(other.qpos, data.qpos)
    np.testing.assert_array_equal(other.sensordata, data.sensordata)
    assert data.qpos[0] != 0.0


def test_a_callback_that_fails_is_heard_and_the_sheath_goes_on():
    model = arm()

    def fail(m, d):
        raise RuntimeError("a user's mistake")

    data = run(model, started(model, 3), 10)
    mujoco.set_mjcb_passive(fail)
    with pytest.raises(RuntimeError, match="a user's mistake"):
        mujoco.mj_step(model, data)
    mujoco.set_mjcb_passive(None)
    mujoco.mj_resetData(model, data)
    run(model, data, 10)
    np.testing.assert_array_equal(
        snapshot(model, data), snapshot(model, run(model, mujoco.MjData(model), 10))
    )
