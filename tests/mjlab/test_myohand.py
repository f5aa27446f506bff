"""MyoSuite's hand with friction in each of its 39 tendons, in each world its own."""

import numpy as np
import pytest

pytest.importorskip("mjlab", reason="the extra `mjlab` is not installed")
pytest.importorskip("myosuite.envs.myo.backends.mjlab", reason="MyoSuite 3 is not installed")
import torch
from mjlab.envs import ManagerBasedRlEnv
from mjlab.tasks.registry import load_env_cfg

import tendon_mj.warp as tw


@pytest.mark.filterwarnings("ignore")  # MyoSuite's own
def test_the_hand_moves_with_a_friction_in_each_world():
    cfg = load_env_cfg("TendonMj-MyoHand-Pose")
    cfg.scene.num_envs, cfg.seed, cfg.decimation = 3, 1, 2
    env = ManagerBasedRlEnv(cfg, "cpu")
    env.reset()
    for _ in range(3):
        observed, *_ = env.step(torch.ones(3, 39))
    sheaths = tw.sheaths_of(env.sim.wp_data)
    friction = sheaths.parameters["friction"].numpy()
    assert np.unique(friction).size == friction.size == 3 * 39
    assert torch.isfinite(observed["critic"]).all()
    assert observed["critic"].shape[1] == observed["actor"].shape[1] + 39
    assert not sheaths.unsolved.numpy().any()
    lost = sheaths.input_tension.numpy() - sheaths.output_tension.numpy()
    assert (lost > 1.0).any()
