"""Registration of the environments with gymnasium, where it is installed."""

from __future__ import annotations

_MODULE = "tendon_mj.envs.gymnasium_finger"
# id -> class, and steps of an episode: 4 s and 6 s
_ENVIRONMENTS = {
    "tendon_mj/HoldForce-v0": ("HoldForceEnv", 400),
    "tendon_mj/FollowTrajectory-v0": ("FollowTrajectoryEnv", 600),
}


def register() -> None:
    """Make the environments known to `gymnasium.make`; without gymnasium nothing is done."""
    try:
        import gymnasium
    except ModuleNotFoundError:
        return
    for name, (kind, steps) in _ENVIRONMENTS.items():
        gymnasium.register(name, f"{_MODULE}:{kind}", max_episode_steps=steps)
