"""Train a policy to press with a force through tendons whose friction nobody tells.

The policy says how much to wind in each motor, not where to: commands drawn afresh every 10 ms
shake the finger, and the force is nowhere near its target. PPO of stable-baselines3 learns it
in some minutes. Needs `pip install 'tendon-mj[gymnasium]'
stable-baselines3`.
"""

import gymnasium
import numpy as np
from stable_baselines3 import PPO
from stable_baselines3.common.env_util import make_vec_env

STEPS, EPISODES, SEED = 122880, 5, 1
START = -0.4, -0.4  # of the ranges; the flexor near the object, as far from it no reward differs
STEP = 0.03  # of the range, in 10 ms


class Winding(gymnasium.Wrapper):
    """Actions are changes of the commands; the observation has the force that is missing."""

    def __init__(self, environment):
        super().__init__(environment)
        self.observation_space = gymnasium.spaces.Box(-10.0, 10.0, (6,))

    def reset(self, **options):
        """Begin an episode with the flexor near the object."""
        self.command = np.array(START)
        seen, info = self.env.reset(**options)
        return self.observe(seen), info

    def step(self, action):
        """Wind in, or pay out, for 10 ms."""
        self.command = np.clip(self.command + STEP * np.clip(action, -1.0, 1.0), -1.0, 1.0)
        seen, *rest = self.env.step(self.command)
        return self.observe(seen), *rest

    def observe(self, seen):
        """Missing and wanted force [N], commands, and tensions at the motors [10 N]."""
        missing = np.clip(seen["target_force"] - seen["tip_force"], -1.0, 1.0)  # [N]
        tensions = np.clip(seen["input_tensions"] / 10.0, 0.0, 10.0)
        parts = missing, seen["target_force"], self.command, tensions
        return np.concatenate(parts).astype(np.float32)


def make():
    """An environment, each episode of which draws its friction."""
    return Winding(gymnasium.make("tendon_mj.envs:tendon_mj/HoldForce-v0"))


several, network = make_vec_env(make, 4, seed=SEED), {"log_std_init": -1.0}
settings = {"gamma": 0.95, "n_steps": 512, "batch_size": 128}
settings["learning_rate"] = lambda remaining: 2e-3 * remaining  # falls to 0
model = PPO("MlpPolicy", several, seed=SEED, device="cpu", policy_kwargs=network, **settings)
model.learn(STEPS)
environment, rewards = make(), []
for seed in range(EPISODES):
    seen, _ = environment.reset(seed=seed)
    truncated = False
    while not truncated:
        action, _ = model.predict(seen, deterministic=True)
        seen, reward, _, truncated, _ = environment.step(action)
        rewards.append(reward)
print(f"mean reward of a step over {EPISODES} episodes after {STEPS} steps: {np.mean(rewards):.3f}")
