"""Largest axial stiffness that a step carries: its closed form, and what lies beyond it."""

import mujoco
import numpy as np
import pytest

from tendon_mj import add_friction, largest_stiffness
from tendon_mj.errors import UnknownNameError
from tests.refusals import refusing
from tests.rigs import compiled, rope, simulated

ARM = 0.03  # of the tendon about the hinge [m]
INERTIA = 1e-4  # of the link [kg m²]
# the last stretch of the tendon is at right angles to its arm
HINGE = f'name="hinge" axis="0 1 0" armature="{INERTIA}"'


def link(step=2e-3, words="", joint=HINGE):
    return rope(
        f"a -.1 0 0; b 0 0 {ARM}",
        f"c .1 0 {ARM}",
        words,
        name="tendon",
        joint=joint,
        geom='size=".001" mass="1e-6"',
        option=f'timestep="{step}" gravity="0 0 0"',
        actuator="",
    )


@pytest.mark.parametrize("step", [1e-3, 2e-3, 5e-3])
def test_it_is_the_length_over_the_mobility_and_the_step_squared(step):
    expected = 0.1 * INERTIA / (step * ARM) ** 2
    assert largest_stiffness(compiled(link(step)), "tendon") == pytest.approx(expected, rel=1e-6)


def swing(stiffness):
    """Largest angle of the link after a push, its tendon held by friction at the middle site."""
    spec = mujoco.MjSpec.from_string(link())
    add_friction(
        spec, "tendon", friction=20.0, axial_stiffness=stiffness, pretension=1e-3 * stiffness
    )
    model = spec.compile()
    data = simulated(model)
    data.qfrc_applied[:] = -data.qfrc_passive  # in balance
    data.qvel[0] = 1e-4
    angles = []
    for _ in range(200):
        mujoco.mj_step(model, data)
        angles.append(abs(data.qpos[0]))
    return max(angles)


def test_a_step_carries_four_times_as_much_alone_and_no_more():
    largest = largest_stiffness(compiled(link()), "tendon")
    calm = swing(largest)
    assert calm < 1e-6
    assert swing(3.6 * largest) < 5.0 * calm
    assert swing(4.4 * largest) > 100.0 * calm


def test_a_tendon_that_moves_nothing_may_be_as_stiff_as_one_likes():
    assert largest_stiffness(compiled(link(joint="<site/>")), "tendon") == np.inf


def test_what_hangs_behind_a_pulley_is_another_stretch():
    branched = link(words="a b /2 b c")
    one = largest_stiffness(compiled(link()), "tendon")
    assert largest_stiffness(compiled(branched), "tendon") == pytest.approx(one, rel=1e-12)


def test_an_unknown_tendon_is_refused_with_the_nearest_name():
    with refusing(UnknownNameError, "did you mean 'tendon'"):
        largest_stiffness(compiled(link()), "tendn")
