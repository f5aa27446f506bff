"""Largest axial stiffness that a step carries: its closed form, and what lies beyond it."""

import re
import warnings

import mujoco
import numpy as np
import pytest

from tendon_mj import Parameters, TendonWarning, add_friction, largest_stiffness, view_sheath
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
    add_friction(spec, "tendon", friction=0.2, axial_stiffness=1.0, pretension=1e-3 * stiffness)
    spec.plugin("tendon_sheath").config |= {
        "axial_stiffness": repr(stiffness),
        "friction": "20.0",
    }
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


def test_a_sheath_stands_for_its_tendon():
    spec = mujoco.MjSpec.from_string(link())
    sheath = {"name": "rope", "friction": 0.1, "axial_stiffness": 10.0, "pretension": 1.0}
    model = add_friction(spec, "tendon", reel="reel", **sheath).compile()
    assert largest_stiffness(model, "rope") == largest_stiffness(model, "tendon")


def test_a_tendon_that_moves_nothing_may_be_as_stiff_as_one_likes():
    assert largest_stiffness(compiled(link(joint="<site/>")), "tendon") == np.inf


def test_what_hangs_behind_a_pulley_is_another_stretch():
    branched = link(words="a b /2 b c")
    one = largest_stiffness(compiled(link()), "tendon")
    assert largest_stiffness(compiled(branched), "tendon") == pytest.approx(one, rel=1e-12)


def said(act, *given):
    """The warning of what a function does, or nothing."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", TendonWarning)
        act(*given)
    assert len(caught) < 2
    return str(caught[0].message) if caught else ""


def step_in(message):
    return float(re.search("take a step of (.*) s,", message)[1])


def wound(stiffness, step=2e-3):
    """A spec with a wound tendon of this stiffness, and the warning of that."""
    spec, law = mujoco.MjSpec.from_string(link(step)), {"pretension": 1.0, "friction": 0.2}
    return spec, said(lambda: add_friction(spec, "tendon", axial_stiffness=stiffness, **law))


@pytest.mark.parametrize("excess", [1.01, 37.0, 1e4])
def test_more_than_the_step_carries_is_told_with_the_step_that_would_do(excess):
    largest = largest_stiffness(compiled(link()), "tendon")
    assert not wound(4.0 * largest)[1]
    message = wound(4.0 * excess * largest)[1]
    assert f"tendon 'tendon': an axial stiffness of {4.0 * excess * largest:.4g} N" in message
    assert 0.9 < step_in(message) / (2e-3 / np.sqrt(excess)) <= 1.0
    assert not wound(4.0 * excess * largest, step_in(message))[1]


@pytest.mark.parametrize("excess", [1.01, 37.0])
def test_a_driven_tendon_whose_guides_have_to_yield_is_told_likewise(excess):
    def driven(stiffness, step):
        spec = mujoco.MjSpec.from_string(link(step))
        spec.add_actuator(trntype=mujoco.mjtTrn.mjTRN_TENDON, target="tendon")
        law = {"friction": 0.2, "axial_stiffness": stiffness}
        return spec, said(lambda: add_friction(spec, "tendon", **law))

    largest = largest_stiffness(compiled(link()), "tendon")
    spec, message = driven(largest, 2e-3)
    assert not message
    message = driven(excess * largest, 2e-3)[1]
    assert f"an axial stiffness of {excess * largest:.4g} N" in message
    assert 0.9 < step_in(message) / (2e-3 / np.sqrt(excess)) <= 1.0
    assert not driven(excess * largest, step_in(message))[1]
    model = spec.compile()
    live = Parameters(model, mujoco.MjData(model))
    assert said(lambda: live.update({"tendon_sheath.axial_stiffness": excess * largest}))


def test_dampers_that_the_integrator_takes_implicitly_count():
    spec = wound(1.0)[0]
    spec.joints[0].damping[0] = 100.0
    model = spec.compile()
    live = Parameters(model, mujoco.MjData(model))
    write = {"tendon_sheath.axial_stiffness": 8.0 * largest_stiffness(model, "tendon")}
    assert not said(lambda: live.update(write))
    model.opt.integrator = mujoco.mjtIntegrator.mjINT_RK4
    assert said(lambda: live.update(write))


def test_a_live_write_is_told_with_the_model_s_step_at_that_time():
    largest = largest_stiffness(compiled(link()), "tendon")
    model = wound(largest)[0].compile()
    data = mujoco.MjData(model)
    live, states = Parameters(model, data), np.tile(data.plugin_state, (3, 1))
    for write in (
        lambda ea: live.update({"tendon_sheath.axial_stiffness": ea}),
        lambda ea: setattr(view_sheath(model, data, "tendon"), "axial_stiffness", ea),
        lambda ea: setattr(view_sheath(model, states, "tendon"), "axial_stiffness", [1.0, ea, 1.0]),
    ):
        model.opt.timestep = 2e-3
        assert not said(write, largest)
        message = said(write, 20.0 * largest)
        assert message.startswith("tendon_sheath.axial_stiffness: an axial stiffness of")
        model.opt.timestep = step_in(message)
        assert not said(write, 20.0 * largest)
        model.opt.timestep = 5e-3
        assert said(write, largest)


def test_a_model_that_is_not_complete_yet_is_not_asked():
    spec = mujoco.MjSpec.from_string(link())
    spec.worldbody.add_body().add_joint()  # without mass
    with pytest.raises(ValueError, match="mass"):
        spec.compile()
    law = {"axial_stiffness": 1e7, "pretension": 1.0, "friction": 0.2}
    assert not said(lambda: add_friction(spec, "tendon", **law))
