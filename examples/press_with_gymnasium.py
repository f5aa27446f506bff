"""Press with a force on an object through tendons whose friction nobody tells: two policies.

The random policy draws its actions. The scripted one winds the flexor in while the tip's force
is too low and pays it out while it is too high, so that it needs no estimate of the friction.
Needs `pip install 'tendon-mj[gymnasium]'`.
"""

import gymnasium
import numpy as np

EPISODES = 5
START = -0.67  # of the flexor's range: the finger straight
GAIN = 0.04  # of the range, for each newton and step of 10 ms


def random_policy(seed):
    """Actions that are drawn."""
    random = np.random.default_rng(seed)
    return lambda seen: random.uniform(-1.0, 1.0, 2)


def scripted_policy():
    """Integral control of the flexor by the force of the tip; the extensor pays out."""
    flexor = START

    def act(seen):
        nonlocal flexor
        missing = float(seen["target_force"][0] - seen["tip_force"][0])  # [N]
        flexor = np.clip(flexor + GAIN * np.clip(missing, -1.0, 1.0), -1.0, 1.0)
        return np.array([flexor, -0.4])

    return act


def mean_reward(environment, policy):
    """Mean reward of a step, from 0 to 1, and the friction of each episode."""
    rewards, frictions = [], []
    for seed in range(EPISODES):
        seen, info = environment.reset(seed=seed)
        frictions.append(info["friction"])
        act, over = policy(seed), False
        while not over:
            seen, reward, terminated, truncated, info = environment.step(act(seen))
            rewards.append(reward)
            over = terminated or truncated
    return np.mean(rewards), frictions


environment = gymnasium.make("tendon_mj.envs:tendon_mj/HoldForce-v0", friction=(0.05, 0.25))
drawn, frictions = mean_reward(environment, random_policy)
scripted, _ = mean_reward(environment, lambda seed: scripted_policy())
print(
    f"mean reward of a step over {EPISODES} episodes with friction {min(frictions):.2f} to "
    f"{max(frictions):.2f}: random {drawn:.3f}, scripted {scripted:.3f}"
)
