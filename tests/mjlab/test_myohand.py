"""MyoSuite's tasks with friction: each kind is put, and the hand moves in several worlds."""

import re

import numpy as np
import pytest

pytest.importorskip("mjlab", reason="the extra `mjlab` is not installed")
pytest.importorskip("myosuite.envs.myo.backends.mjlab", reason="MyoSuite 3 is not installed")
import torch
from mjlab.envs import ManagerBasedRlEnv
from mjlab.scene import Scene
from mjlab.tasks.registry import list_tasks, load_env_cfg

import tendon_mj.mjlab
import tendon_mj.warp as tw
from tendon_mj.plugin import sheaths

# of tasks that differ in the state of the muscles, the pose or a random start, one
KINDS = {
    re.sub(r"Fati|Sarc|(?<=Tennis)P\d|\d?(Fixed|Random)|(For|Back)ward|-v0", "", task): task
    for task in list_tasks()
    if task.startswith(("myo", "motor"))
}


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


@pytest.mark.filterwarnings("ignore")  # of tendons that no muscle pulls, and MyoSuite's own
@pytest.mark.parametrize("kind", KINDS)
def test_each_kind_of_task_is_put_with_friction(kind):
    cfg = load_env_cfg(KINDS[kind])
    cfg.scene.num_envs = 2
    if "ChaseTag" in kind:
        pytest.skip("its own keyframe does not fit its scene")
    tendon_mj.mjlab.add_friction(cfg, "*", friction=0.1)
    model = Scene(cfg.scene, "cpu").compile()
    assert 0.8 * model.ntendon < len(sheaths(model)) <= model.ntendon
    tw.put_model(model)
