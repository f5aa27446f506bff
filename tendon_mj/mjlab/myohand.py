"""Task of mjlab: MyoSuite's hand takes poses through tendons with friction."""

from __future__ import annotations

from typing import Any

from mjlab.managers.event_manager import EventTermCfg
from mjlab.managers.observation_manager import ObservationTermCfg
from mjlab.tasks.registry import load_env_cfg, load_rl_cfg, load_runner_cls

from tendon_mj.mjlab.scene import add_friction
from tendon_mj.warp import draw_parameters, tension

HAND = "myoHandPoseRandom-v0"  # of MyoSuite
_FRICTION = {"*.friction": (0.0, 0.2)}


def hand_cfgs() -> tuple[Any, ...]:
    """Configurations of environment, play, training and its runner, of MyoSuite's task.

    Each world draws the friction of each tendon at every reset; the critic knows the tensions that
    arrive at the insertions.
    """
    cfgs = load_env_cfg(HAND), load_env_cfg(HAND, play=True)
    for cfg in cfgs:
        add_friction(cfg, "robot/*", friction=0.1)
        cfg.events["friction"] = EventTermCfg(
            func=draw_parameters, mode="reset", params={"ranges": _FRICTION}
        )
        cfg.observations["critic"].terms["tension"] = ObservationTermCfg(func=tension, scale=0.01)
    return *cfgs, load_rl_cfg(HAND), load_runner_cls(HAND)
