"""A sheath beside MuJoCo's own plugins and a user's callbacks."""

import mujoco
import numpy as np
import pytest

from tendon_mj import add_friction
from tests.rigs import MUJOCO, arm, arm_xml, rope, run, simulated, snapshot, started

# a cable of MuJoCo's elasticity plugin, far from the arm
CABLE = """
    <composite prefix="rope" type="cable" curve="s 0 0" count="9 1 1" size=".3" initial="none"
        offset="2 0 1">
      <plugin plugin="mujoco.elasticity.cable"><config key="twist" value="1e6"/>
        <config key="bend" value="1e6"/></plugin>
      <geom type="capsule" size=".005" mass=".01"/>
    </composite>
"""
STEPS = 100


@pytest.fixture(autouse=True)
def no_callback_stays():
    yield
    for name in ("passive", "control", "act_gain"):
        getattr(mujoco, f"set_mjcb_{name}")(None)


@pytest.mark.skipif(MUJOCO >= (4, 0), reason="MuJoCo 4.0 has no plugin `mujoco.elasticity.cable`")
def test_a_plugin_of_mujocos_own():
    """Neither changes what the other does to its own bodies."""
    text = arm_xml().replace("</worldbody>", CABLE + "</worldbody>")
    use = '<extension><plugin plugin="mujoco.elasticity.cable"/>'
    both = mujoco.MjModel.from_xml_string(text.replace("<extension>", use))
    alone = arm()
    data, own = (simulated(model, STEPS) for model in (both, alone))
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
    text = rope(
        "a -.2 0 .1; b -.1 0 .02",
        "c .02 0 .03; d .08 0 .02",
        joint='axis="0 1 0" stiffness="1" damping=".1" armature="1e-3"',
        geom='type="capsule" fromto="0 0 0 .1 0 0" size=".01" mass=".1"',
        actuator=f'<general tendon="t" {gain}/>',
    )
    return add_friction(mujoco.MjSpec.from_string(text), "t", friction=0.3).compile()


def test_a_control_callback_is_a_control_that_is_set():
    """But for the first: the tendon is laid before it is set. Both come to rest."""
    model = pulled('gainprm="-1"')
    mujoco.set_mjcb_control(lambda m, d: d.ctrl.fill(5.0))
    called = simulated(model, 3000)
    mujoco.set_mjcb_control(None)
    data = simulated(model, 3000, ctrl=5.0)
    for ended in (called, data):
        assert abs(ended.qvel[0]) < 1e-6
        assert ended.sensordata[0] == pytest.approx(5.0)  # the input tension
        assert 0.0 < ended.sensordata[1] < 5.0  # and the output's
    np.testing.assert_allclose(called.qpos, data.qpos, rtol=1e-2)


def test_a_gain_of_a_user_s_own_is_rubbed_as_mujocos():
    given, own = pulled('gainprm="-2"'), pulled('gaintype="user"')
    assert own.actuator_gaintype[0] == mujoco.mjtGain.mjGAIN_USER
    data = simulated(given, STEPS, ctrl=4.0)
    mujoco.set_mjcb_act_gain(lambda m, d, actuator: -2.0)
    other = simulated(own, STEPS, ctrl=4.0)
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
