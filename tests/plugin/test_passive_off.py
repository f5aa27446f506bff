"""Sheaths where MuJoCo leaves out all passive forces, because its springs and dampers are off."""

import mujoco
import numpy as np

from tests.plugin.rigs import driven, hand, reeled, unpacked

OFF = mujoco.mjtDisableBit.mjDSBL_SPRING | mujoco.mjtDisableBit.mjDSBL_DAMPER


def test_a_sheath_that_is_wound_acts_all_the_same():
    model = hand(friction=0.1).compile()
    model.jnt_stiffness[:], model.dof_damping[:] = 0.0, 0.0
    plain, data = mujoco.MjData(model), mujoco.MjData(model)
    plain.qvel[:] = data.qvel[:] = 0.01
    mujoco.mj_step(model, plain, 20)
    model.opt.disableflags |= OFF
    mujoco.mj_step(model, data, 20)
    np.testing.assert_allclose(data.qpos, plain.qpos, rtol=1e-9, atol=1e-12)
    assert unpacked(model, data)[0].unsolved == 0.0


def test_reels_wind_all_the_same():
    model = reeled()
    model.opt.disableflags |= OFF
    data = mujoco.MjData(model)
    data.ctrl[:] = 1e-3
    mujoco.mj_step(model, data, 3)
    assert data.sensor("input_tension").data[0] > 25.0


def test_one_that_is_driven_counts_that_it_was_left_out():
    model = driven()
    model.opt.disableflags |= OFF
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, 3)
    assert unpacked(model, data, "wrapped_sheath")[0].unsolved == 3.0
