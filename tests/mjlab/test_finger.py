"""The task of a finger in mjlab: listed, trained, reset, and each world as MuJoCo simulates it."""

from dataclasses import asdict
from importlib.metadata import entry_points

import mujoco
import numpy as np
import pytest

import tendon_mj

pytest.importorskip("mjlab", reason="the extra `mjlab` is not installed")
import torch
from mjlab.envs import ManagerBasedRlEnv
from mjlab.managers.event_manager import EventTermCfg
from mjlab.rl import MjlabOnPolicyRunner, RslRlVecEnvWrapper
from mjlab.scripts.list_envs import list_environments
from mjlab.tasks.registry import load_env_cfg, load_rl_cfg
from mjlab.viewer.native.viewer import NativeMujocoViewer

import tendon_mj.warp as tw

TASK = "TendonMj-Finger-Follow"
SHEATHS = ("robot/flexor_sheath", "robot/extensor_sheath")
FRICTION = np.linspace(0.05, 0.4, 8)
ACTIONS = 1.2 * (1.0 - torch.cos(0.5 * torch.arange(20)))[:, None] * torch.tensor([1.0, -1.0])


def environment(friction=FRICTION, steps=1, **events):
    """An environment of ``steps`` physical steps a step, whose worlds have a friction each."""
    cfg = load_env_cfg(TASK)
    cfg.scene.num_envs, cfg.decimation = len(friction), steps
    del cfg.events["friction"]
    cfg.events |= events
    env = ManagerBasedRlEnv(cfg, "cpu")
    env.reset()
    tw.sheaths_of(env.sim.wp_data).set("friction", np.array(friction)[:, None])
    return env


def step(env, actions):
    """Step all worlds alike."""
    for row in actions:
        env.step(row.expand(env.num_envs, 2))
    return env.sim.wp_data.qpos.numpy().copy()


def test_the_task_is_found_by_mjlab(capsys):
    assert [point.value for point in entry_points(group="mjlab.tasks", name="tendon_mj")] == [
        "tendon_mj.mjlab"
    ]
    assert list_environments(keyword=TASK) == 1
    assert TASK in capsys.readouterr().out


@pytest.mark.filterwarnings("ignore")  # of what rsl_rl and Torch deprecate
def test_training_goes_through_frictions_with_finite_numbers(tmp_path):
    cfg, agent = load_env_cfg(TASK), load_rl_cfg(TASK)
    cfg.scene.num_envs, cfg.decimation, cfg.seed = 8, 2, 1
    agent.num_steps_per_env = 4
    agent.algorithm.num_learning_epochs = agent.algorithm.num_mini_batches = 1
    env = RslRlVecEnvWrapper(ManagerBasedRlEnv(cfg, "cpu"))
    runner = MjlabOnPolicyRunner(env, asdict(agent), str(tmp_path), "cpu")
    before = [weight.clone() for weight in runner.alg.actor.parameters()]
    runner.learn(num_learning_iterations=5)
    after = list(runner.alg.actor.parameters())
    assert all(torch.isfinite(weight).all() for weight in after)
    assert any((old != new).any() for old, new in zip(before, after, strict=True))
    sheaths = tw.sheaths_of(env.unwrapped.sim.wp_data)
    friction = sheaths.parameters["friction"].numpy()
    assert np.unique(friction).size == friction.size == 16
    assert (friction >= 0.05).all()
    assert (friction <= 0.3).all()
    assert np.isfinite(sheaths.tension.numpy()).all()
    assert not sheaths.unsolved.numpy().any()


@pytest.mark.parametrize("steps", [1, 7])
def test_worlds_that_are_reset_are_as_in_a_fresh_environment_and_others_go_on(steps):
    env, fresh, on = environment(), environment(), environment()
    for one in (env, on):
        step(one, ACTIONS[:steps])
    env.reset(env_ids=torch.tensor([2, 5]))
    after, first, other = (step(one, ACTIONS) for one in (env, fresh, on))
    reset = np.isin(np.arange(8), [2, 5])
    np.testing.assert_array_equal(after[reset], first[reset])
    np.testing.assert_array_equal(after[~reset], other[~reset])
    assert (after[~reset] != first[~reset]).any(axis=1).all()


def test_a_world_is_what_it_is_alone_and_what_mujoco_simulates():
    env, alone = environment(), environment(FRICTION[5:6])
    model = env.sim.mj_model
    data = mujoco.MjData(model)
    live = tendon_mj.Parameters(model, data)
    for name in SHEATHS:
        live[f"{name}.friction"] = FRICTION[5]
    on_device, here = [], []
    for row in ACTIONS.repeat_interleave(5, dim=0)[:, None]:
        np.testing.assert_array_equal(step(env, row)[5], step(alone, row)[0])
        data.ctrl[:] = env.sim.wp_data.ctrl.numpy()[5]
        mujoco.mj_step(model, data)
        mujoco.mj_forward(model, data)  # as mjlab does once more before it observes
        here.append([tendon_mj.view_sheath(model, data, name).output_tension for name in SHEATHS])
        on_device.append(tw.tension(env)[5].tolist())
    np.testing.assert_allclose(env.sim.wp_data.qpos.numpy()[5], data.qpos, atol=1e-5)
    np.testing.assert_allclose(on_device, here, atol=1e-4 * np.ptp(here))


def test_the_native_viewer_shows_a_world_s_tensions_and_changes_none():
    def copy(env, env_ids):
        tw.get_data_into(env.sim.mj_data, env.sim.mj_model, env.sim.wp_data, 5)

    shown, plain = environment(copy=EventTermCfg(func=copy, mode="step")), environment()
    viewer = NativeMujocoViewer(shown, None)
    viewer.mjm, viewer.mjd, viewer.env_idx = shown.sim.mj_model, shown.sim.mj_data, 5
    for row in ACTIONS:
        np.testing.assert_array_equal(step(shown, row[None]), step(plain, row[None]))
        viewer._sync_env_state_to_mjdata(viewer.mjd, shown.sim.data, 5)
        mujoco.mj_forward(viewer.mjm, viewer.mjd)
        here = [tendon_mj.view_sheath(viewer.mjm, viewer.mjd, k).output_tension for k in SHEATHS]
        np.testing.assert_allclose(tw.tension(shown)[5], here, rtol=1e-3)
