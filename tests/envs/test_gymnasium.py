"""The gymnasium environments keep its contract, and are dm_control's to float32's rounding."""

import itertools
import shutil
import sys

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from tendon_mj.attach import Parameters
from tendon_mj.envs import HoldForceEnv, Ranges, follow_trajectory, hold_force
from tendon_mj.errors import InvalidValueError
from tests.envs.screens import can_draw, run_without_screen
from tests.refusals import refusing, silent

IDS = {
    "hold_force": "tendon_mj.envs:tendon_mj/HoldForce-v0",
    "follow_trajectory": "tendon_mj.envs:tendon_mj/FollowTrajectory-v0",
}
MAKERS = {"hold_force": hold_force, "follow_trajectory": follow_trajectory}
HOLD_FORCE = IDS["hold_force"]
DRAW = """
import sys, gymnasium
environment = gymnasium.make(sys.argv[1], render_mode=sys.argv[2])
for seed in range(2):  # another bend, another model
    environment.reset(seed=seed)
    environment.step([0.0, 0.0])
    print(environment.render() is None)
"""  # and no close()


@pytest.mark.parametrize("name", IDS.values(), ids=IDS)
def test_gymnasium_s_checker_has_no_warning(name):
    environment = gymnasium.make(name)
    with silent():
        check_env(environment.unwrapped, skip_render_check=True)  # "human" needs a screen


@pytest.mark.parametrize("name", IDS.values(), ids=IDS)
def test_every_observation_is_in_its_space_whatever_the_agent_does(name):
    environment = gymnasium.make(name)
    spaces = environment.observation_space.values()
    assert {space.dtype for space in spaces} == {np.dtype(np.float32)}
    random = np.random.default_rng(0)
    for seed in range(3):
        seen, _ = environment.reset(seed=seed)
        assert environment.observation_space.contains(seen)
        for _ in range(100):
            action = random.choice([-1.0, 1.0], 2)
            seen, reward, *_ = environment.step(action)
            assert environment.observation_space.contains(seen)
            assert 0.0 <= reward <= 1.0


@pytest.mark.parametrize("drawn", [(0.05, 0.1), (0.2, 0.2)])
def test_friction_is_drawn_from_the_range_that_make_was_given_and_acts(drawn):
    environment = gymnasium.make(HOLD_FORCE, friction=drawn)
    frictions = []
    for seed in range(5):
        _, info = environment.reset(seed=seed)
        parameters = Parameters(*environment.unwrapped.simulation.native)
        assert parameters["flexor_sheath.friction"] == info["friction"]
        *_, later = environment.step(np.zeros(2))
        assert later == info
        frictions.append(info["friction"])
    assert drawn[0] <= min(frictions) <= max(frictions) <= drawn[1]
    assert len(set(frictions)) == (1 if drawn[0] == drawn[1] else 5)


@pytest.mark.parametrize("name", IDS.values(), ids=IDS)
def test_the_time_limit_truncates_and_nothing_terminates(name):
    environment = gymnasium.make(name, max_episode_steps=3)
    environment.reset(seed=0)
    ends = [environment.step(np.zeros(2))[2:4] for _ in range(3)]
    assert ends == [(False, False), (False, False), (False, True)]


@pytest.mark.parametrize("name", IDS)
def test_an_episode_is_as_long_as_dm_control_s(name):
    limit = gymnasium.spec(IDS[name].partition(":")[2]).max_episode_steps
    environment = MAKERS[name](seed=0, ranges=Ranges(bend=(1.0, 1.0)))
    step, count = environment.reset(), 0
    while not step.last():
        step = environment.step(np.zeros(2))
        count += 1
    assert count == limit


@pytest.mark.parametrize("name", IDS)
def test_with_the_same_draws_it_is_dm_control_s_environment_to_float32_s_rounding(name):
    one = MAKERS[name](seed=7)
    other = gymnasium.make(IDS[name]).unwrapped
    other.reset(seed=0)
    # the same generator for both, as gymnasium's own is of another kind
    other.np_random = np.random.RandomState(7)
    step, (seen, info) = one.reset(), other.reset()
    assert info == one.task.drawn
    random = np.random.default_rng(1)
    for _ in range(100):
        for reading, values in step.observation.items():
            np.testing.assert_array_equal(values.astype(np.float32), seen[reading])
        action = random.uniform(-0.5, 0.5, 2)
        step, (seen, reward, *_) = one.step(action), other.step(action)
        assert step.reward == reward


@pytest.mark.parametrize(
    ("name", "mode"),
    [("hold_force", "sync"), ("follow_trajectory", "sync"), ("hold_force", "async")],
)
def test_vectorised_environments_are_single_ones_to_the_bit(name, mode):
    name = IDS[name]
    count, length, steps = 2, 20, 50  # the episodes end, and others begin, on the way
    kwargs = {"context": "spawn"} if mode == "async" else {}
    many = gymnasium.make_vec(
        name,
        num_envs=count,
        vectorization_mode=mode,
        vector_kwargs=kwargs,
        max_episode_steps=length,
        friction=(0.1, 0.2),
    )
    ones = [
        gymnasium.make(name, max_episode_steps=length, friction=(0.1, 0.2)) for _ in range(count)
    ]
    actions = np.random.default_rng(0).uniform(-1.0, 1.0, (steps, count, 2))
    try:
        seen, info = many.reset(seed=11)
        single = [one.reset(seed=11 + k) for k, one in enumerate(ones)]
        over = [False] * count
        for k, action in enumerate(actions):
            for j in range(count):
                assert info["friction"][j] == single[j][-1]["friction"]
                for reading, values in single[j][0].items():
                    np.testing.assert_array_equal(seen[reading][j], values)
            seen, reward, _, truncated, info = many.step(action)
            for j, one in enumerate(ones):
                if over[j]:  # the step after the last one is a reset
                    single[j] = one.reset()
                    over[j] = False
                else:
                    single[j] = one.step(action[j])
                    assert reward[j] == single[j][1]
                    over[j] = single[j][3]
                assert truncated[j] == over[j], f"step {k}"
    finally:
        many.close()


@pytest.mark.parametrize("name", IDS.values(), ids=IDS)
def test_a_picture_has_its_size_and_shows_motion_and_target(name):
    if not can_draw():
        pytest.skip("no OpenGL to draw with")
    environment = gymnasium.make(name, render_mode="rgb_array", width=96, height=64)
    with silent():
        environment.reset(seed=0)
        pictures = [environment.render()]
        for _ in range(60):
            environment.step(np.array([0.5, -0.5]))
        pictures.append(environment.render())
        environment.unwrapped.task.draw_target = lambda physics, scene: None
        pictures.append(environment.render())
        environment.close()
    assert {(p.shape, p.dtype.name) for p in pictures} == {((64, 96, 3), "uint8")}
    for before, after in itertools.pairwise(pictures):
        assert (np.abs(before.astype(int) - after).max(axis=2) > 50).mean() > 0.001


def test_without_a_screen_pictures_are_drawn_in_silence_until_the_interpreter_ends():
    if not can_draw():
        pytest.skip("no OpenGL to draw with")
    done = run_without_screen(DRAW, HOLD_FORCE, "rgb_array")
    assert (done.stdout.split(), done.stderr) == (["False"] * 2, "")


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere windows need no DISPLAY")
def test_a_window_without_a_screen_is_refused_and_the_other_mode_named():
    done = run_without_screen(DRAW, HOLD_FORCE, "human")
    assert "EngineError: there is no screen" in done.stderr
    assert "'rgb_array'" in done.stderr


def test_a_window_shows_episodes_until_the_interpreter_ends():
    if shutil.which("xvfb-run") is None:
        pytest.skip("there is no xvfb-run here")
    done = run_without_screen(DRAW, HOLD_FORCE, "human", screen=("xvfb-run", "-a"))
    if "GLX" in done.stderr:
        pytest.skip(f"nothing can be drawn on that screen: {done.stderr}")
    assert (done.stdout.split(), done.stderr) == (["True"] * 2, "")


@pytest.mark.parametrize("given", [{"friction": (0.2, 0.1)}, {"render_mode": "ansi"}])
def test_invalid_arguments_are_refused_when_made(given):
    ((name, value),) = given.items()
    with refusing(InvalidValueError, f"{name} = {value!r}"):
        HoldForceEnv(**given)


def test_options_and_actions_without_meaning_are_refused():
    environment = HoldForceEnv()
    with pytest.raises(InvalidValueError, match=r"options = .*gymnasium.make"):
        environment.reset(options={"friction": 0.1})
    environment.reset(seed=0)
    with pytest.raises(InvalidValueError):
        environment.step(np.array([np.nan, 0.0]))
