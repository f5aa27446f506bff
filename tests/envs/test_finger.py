"""Environments keep dm_env's contract, and the sheaths' state survives dm_control's operations."""

from __future__ import annotations

import math
import pickle

import numpy as np
import pytest
from absl.testing import absltest
from dm_env import test_utils

from tendon_mj.attach import Parameters
from tendon_mj.envs import Ranges, follow_trajectory, hold_force
from tendon_mj.envs.finger import FingerPhysics
from tendon_mj.errors import InvalidValueError
from tendon_mj.models import Finger
from tendon_mj.plugin import sheath_arrays, sheaths
from tests.envs.screens import can_draw, run_without_screen
from tests.refusals import refusing

DRAW = """
from tendon_mj.envs import hold_force
environment = hold_force(seed=0)
environment.reset()
environment.step([0.0, 0.0])
drawn = environment.physics.render(48, 64)
with_target = environment.physics.render(48, 64, scene_callback=environment.task.draw_target)
print(with_target.shape, (drawn != with_target).any())
"""
MAKERS = {"hold_force": hold_force, "follow_trajectory": follow_trajectory}
KEPT_BEND = (math.pi / 2.0, math.pi / 2.0)


class TestHoldForceKeepsTheContract(test_utils.EnvironmentTestMixin, absltest.TestCase):
    def make_object_under_test(self):
        return hold_force(seed=1, time_limit=0.1)


class TestFollowTrajectoryKeepsTheContract(test_utils.EnvironmentTestMixin, absltest.TestCase):
    def make_object_under_test(self):
        return follow_trajectory(seed=1, time_limit=0.1)


def episode(environment, seed, steps=None):
    """Observations and rewards of a random policy until the end, or for some steps."""
    random, spec = np.random.RandomState(seed), environment.action_spec()
    step, seen = environment.reset(), []
    while not step.last() and (steps is None or len(seen) < steps):
        step = environment.step(random.uniform(spec.minimum, spec.maximum, spec.shape))
        seen.append(np.concatenate([[step.reward or 0.0], *step.observation.values()]))
    return np.array(seen)


@pytest.mark.parametrize("make", MAKERS.values(), ids=MAKERS)
def test_a_random_policy_sees_finite_numbers_and_rewards_between_0_and_1(make):
    seen = episode(make(seed=3, time_limit=3.0), 0)
    assert len(seen) == 300
    assert np.isfinite(seen).all()
    assert 0.0 <= seen[:, 0].min() <= seen[:, 0].max() <= 1.0


@pytest.mark.parametrize("make", MAKERS.values(), ids=MAKERS)
def test_the_same_seed_gives_the_same_episodes_and_another_seed_others(make):
    one, same, other = make(seed=5), make(seed=5), make(seed=6)
    for _ in range(2):  # the second episode too
        a, b, c = (episode(e, 0, 50) for e in (one, same, other))
        np.testing.assert_array_equal(a, b)
        assert np.abs(a - c).max() > 1e-3


def test_episodes_have_a_friction_a_pretension_and_a_bend_from_the_ranges():
    ranges = Ranges(friction=(0.1, 0.2), pretension=(3.0, 5.0))
    environment = hold_force(seed=2, ranges=ranges)
    frictions, bends = set(), set()
    for _ in range(5):
        step = environment.reset()
        parameters = Parameters(environment.physics.model.ptr, environment.physics.data.ptr)
        friction = parameters["flexor_sheath.friction"]
        assert 0.1 <= friction <= 0.2
        assert friction == parameters["extensor_sheath.friction"]
        pretension = parameters["flexor_sheath.pretension"]
        assert 3.0 <= pretension <= 5.0
        np.testing.assert_allclose(step.observation["input_tensions"], pretension, rtol=1e-9)
        frictions.add(friction)
        bends.add(environment.task.drawn["bend"])
        heading = np.diff(
            [environment.physics.data.ptr.site(f"flexor_sheath_{k}").xpos for k in (3, 4)], axis=0
        )[0]
        risen = math.atan2(heading[2], heading[0])
        assert risen == pytest.approx(environment.task.drawn["bend"] / 2.0, abs=1e-9)
    assert len(frictions) == len(bends) == 5


def test_a_kept_bend_keeps_the_model():
    environment = hold_force(seed=2, ranges=Ranges(bend=KEPT_BEND))
    model = environment.physics.model.ptr
    for _ in range(3):
        environment.reset()
        assert environment.physics.model.ptr is model


def moved(physics, steps=200):
    physics.command(np.array([2.0, -1.0]))
    physics.step(steps)
    return physics.data.ptr.qpos.copy(), physics.data.ptr.plugin_state.copy()


@pytest.mark.parametrize(
    "copied",
    [
        lambda physics: physics.copy(share_model=True),
        lambda physics: physics.copy(share_model=False),
        lambda physics: pickle.loads(pickle.dumps(physics)),
    ],
    ids=["shared", "deep", "pickled"],
)
def test_a_copy_goes_on_as_the_original(copied):
    physics = FingerPhysics.of(Finger())
    physics.start(Finger(friction=0.25))
    moved(physics)
    other = copied(physics)
    np.testing.assert_array_equal(other.data.ptr.qpos, physics.data.ptr.qpos)
    for name, sheath in sheaths(physics.model.ptr).items():
        copy, original = (
            sheath_arrays(of.model.ptr, of.data.ptr.plugin_state, name, sheath.state).state
            for of in (other, physics)
        )
        assert copy["law"] == original["law"]
        for field in ("wound_in", "wound_out", "commit_time", "unsolved"):
            assert copy[field] == original[field]
    for one, two in zip(moved(physics), moved(other), strict=True):
        # dm_control evaluates a copy once, which moves the constraint solver's first guess
        np.testing.assert_allclose(one, two, rtol=1e-9, atol=1e-12)
    assert Parameters(other.model.ptr, other.data.ptr)["flexor_sheath.friction"] == 0.25


def test_a_reset_forgets_the_motion_and_the_live_parameters():
    physics = FingerPhysics.of(Finger())
    physics.start(Finger(friction=0.25))
    first = moved(physics)
    with physics.reset_context():
        pass
    assert Parameters(physics.model.ptr, physics.data.ptr)["flexor_sheath.friction"] == 0.15
    physics.start(Finger(friction=0.25))
    for one, two in zip(first, moved(physics), strict=True):
        np.testing.assert_array_equal(one, two)


def test_friction_is_felt():
    """Equal motor motions, unequal joint motions."""
    answers = []
    for friction in (0.05, 0.25):
        ranges = Ranges(friction=(friction, friction), pretension=(4.0, 4.0), bend=KEPT_BEND)
        environment = follow_trajectory(seed=0, ranges=ranges)
        environment.reset()
        for _ in range(100):
            step = environment.step(np.array([0.0, -0.3]))
        answers.append(step.observation["joint_angles"])
    assert np.abs(answers[0] - answers[1]).max() > np.radians(3.0)


@pytest.mark.parametrize(
    ("field", "bad", "facts"),
    [
        ("friction", (0.2, 0.1), "[-] in order"),
        ("friction", (-0.1, 0.1), "≥ 0"),
        ("friction", (math.nan, 1.0), "finite"),
        ("friction", 0.2, "pair"),
        ("friction", "ab", "pair"),
        ("pretension", (1.0, 2.0, 3.0), "[N] pair"),
        ("bend", None, "[rad] pair"),
        ("axial_stiffness", (0, 0), "> 0"),
    ],
)
def test_ranges_that_are_not_lawful_pairs_are_refused_when_made(field, bad, facts):
    with refusing(InvalidValueError, f"{field} = {bad!r}", *facts.split()):
        Ranges(**{field: bad})


def test_a_bend_in_degrees_is_refused_when_the_environment_is_made():
    with pytest.raises(InvalidValueError, match=r"bend = \(60.0, 180.0\) \[rad\] must be at most"):
        hold_force(seed=0, ranges=Ranges(bend=(60, 180)))


def test_an_action_beyond_its_range_counts_as_its_end():
    ends = []
    for action in ([1.0, -1.0], [2.0, -5.0]):
        environment = hold_force(seed=0, ranges=Ranges(bend=KEPT_BEND))
        environment.reset()
        ends.append(environment.step(np.array(action)).observation["motor_angles"])
    np.testing.assert_array_equal(*ends)


@pytest.mark.parametrize("action", [0.0, [0.0], [0.0] * 3, [[0.0, 0.0]], [0.0, math.nan], None])
def test_an_action_that_is_not_a_number_for_each_tendon_is_refused(action):
    environment = hold_force(seed=0, ranges=Ranges(bend=KEPT_BEND))
    environment.reset()
    with refusing(InvalidValueError, f"action = {action!r}"):
        environment.step(action)
    environment.step([0.0, 0.0])


def test_without_a_screen_dm_control_draws_in_silence_until_the_interpreter_ends():
    if not can_draw():
        pytest.skip("no OpenGL to draw with")
    done = run_without_screen(DRAW)
    assert (done.stdout.strip(), done.stderr) == ("(48, 64, 3) True", "")
