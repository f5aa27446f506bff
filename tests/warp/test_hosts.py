"""Another package's code puts models with sheaths, once it takes them, and others as before."""

import types

import mujoco
import numpy as np
import pytest

from tendon_mj.errors import InvalidValueError
from tests.refusals import refusing
from tests.warp.models import controls, fingers, mjw, step, tw

pytest.importorskip("warp")

PLAIN = "<mujoco><worldbody><body><joint/><geom size='.1'/></body></worldbody></mujoco>"


def a_host():
    """A module that puts models as mjlab's does."""
    host = types.ModuleType("host")
    source = """
def start(model, data, worlds):
    return mjwarp.put_model(model), mjwarp.put_data(model, data, nworld=worlds)

def reset(m, d):
    mjwarp.reset_data(m, d)
"""
    host.mjwarp = mjw
    exec(source, vars(host))
    return host


def test_a_host_that_takes_sheaths_simulates_what_this_package_does():
    model, host = fingers(kinds=("drum",)), a_host()
    tw.take_sheaths(host)
    m, d = host.start(model, mujoco.MjData(model), 2)
    other_m, other = tw.put_model(model), tw.make_data(model, 2)
    for row in controls(model, 5):
        step(m, d, row)
        step(other_m, other, row)
    np.testing.assert_array_equal(d.qpos.numpy(), other.qpos.numpy())
    assert (tw.sheaths_of(d).input_tension.numpy() > 0.0).all()
    tw.sheaths_of(d).set("friction", np.array([[0.3], [0.1]]))
    host.reset(m, d)
    np.testing.assert_allclose(tw.sheaths_of(d).parameters["friction"].numpy()[:, 0], [0.3, 0.1])


def test_a_model_without_sheaths_is_put_as_before():
    model, host = mujoco.MjModel.from_xml_string(PLAIN), a_host()
    tw.take_sheaths(host)
    m, d = host.start(model, mujoco.MjData(model), 2)
    mjw.step(m, d)
    host.reset(m, d)
    assert d.time.numpy().tolist() == [0.0, 0.0]


def test_a_host_gets_its_own_functions_back():
    model, host = fingers(kinds=("drum",)), a_host()
    give_back = tw.take_sheaths(host)
    assert host.mjwarp.step is mjw.step
    give_back()
    assert host.mjwarp is mjw
    with pytest.raises(NotImplementedError, match="mjSENS_PLUGIN"):
        host.start(model, mujoco.MjData(model), 1)


def test_what_does_not_call_mujoco_warp_is_refused():
    with refusing(InvalidValueError, "numpy", "no attribute that is the module mujoco_warp"):
        tw.take_sheaths(np)
