"""Sheaths at the ends of what can be given: finite, solved, or told by name."""

import re
from dataclasses import replace

import mujoco
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as some

from tendon_mj.plugin import sheaths
from tests.guarantees.random_tendon import cases, diverged, moved, thorough
from tests.rigs import fixed_sheaths, sheath_view, unpacked, warnings_of_ours

STEPS = 60
pytestmark = pytest.mark.filterwarnings("ignore::tendon_mj.TendonWarning")


@pytest.fixture(autouse=True, scope="module")
def told():
    """Warnings of ours that MuJoCo was given."""
    with warnings_of_ours() as messages:
        yield messages


def uneven_arc(length, bend, guides, spread, rng):
    """Points of a tendon in a plane, evenly bent, whose stretches differ by up to 10^spread."""
    stretches = 10.0 ** rng.uniform(-spread, 0.0, guides + 1)
    angles = bend / guides * np.arange(guides + 1)
    ahead = np.stack([np.cos(angles), np.sin(angles), 0.0 * angles], axis=1)
    steps = ahead * (length * stretches / stretches.sum())[:, None]
    return np.concatenate([np.zeros((1, 3)), np.cumsum(steps, axis=0)])


def stay_solved(
    loss, bend, stiffness, guides, length, spread, pretension, strain, timestep, seed, **drag
):
    """Drive a tendon between fixed ends to and fro: each step is solved, each tension finite."""
    rng = np.random.default_rng(seed)
    guides = max(guides, int(bend / 3.0) + 1)  # a guide turns by π at most
    law = {
        "points": uneven_arc(length, bend, guides, spread, rng),
        "friction": loss / bend,
        "axial_stiffness": 10.0**stiffness,
        "pretension": pretension,
        **drag,
    }
    model = fixed_sheaths([law], timestep)
    data = mujoco.MjData(model)
    for _ in range(STEPS):
        data.ctrl[0] = strain * length * rng.uniform(-1.0, 1.0)
        mujoco.mj_step(model, data)
        scalars, segments, _ = unpacked(model, data, "sheath0")
        assert scalars.unsolved == 0
        assert np.isfinite(data.plugin_state).all()
        assert (segments["tension"] >= 0.0).all()


def powers(low, high):
    """Numbers from 10^low to 10^high."""
    return some.floats(low, high).map(lambda power: 10.0**power)


tendons = {
    "loss": some.floats(0.0, 20.0),
    "bend": some.floats(0.05, 100.0),
    "stiffness": some.floats(2.0, 8.0),
    "length": some.sampled_from([0.005, 0.05, 0.5, 3.0]),
    "spread": some.sampled_from([0.0, 0.0, 1.0, 2.0]),
    "pretension": some.sampled_from([0.0, 1e-6, 1.0, 100.0]),
    "strain": some.sampled_from([1e-9, 1e-6, 1e-4, 1e-2, 0.1]),
    "timestep": some.sampled_from([1e-4, 1e-3, 5e-3]),
    "seed": some.integers(0, 2**32 - 1),
}
drags = some.fixed_dictionaries(
    {"viscous_friction": some.just(0.0) | powers(-4, 3), "tendon_mass": powers(-4, 3)}
) | some.fixed_dictionaries({"viscous_friction": powers(-4, 3)})


@thorough
@given(guides=some.integers(1, 512), **tendons)
def test_a_tendon_between_fixed_ends_is_solved(guides, **tendon):
    """λ to 20, EA from 1e2 to 1e8 N, to 512 guides, slack and tight again."""
    stay_solved(guides=guides, **tendon)


@thorough
@given(guides=some.integers(1, 64), drag=drags, **{**tendons, "loss": some.floats(0.0, 15.0)})
def test_a_viscous_or_heavy_tendon_between_fixed_ends_is_solved(guides, drag, **tendon):
    """λ to 15 and to 64 guides where sliding itself takes tension.

    Beyond λ = 15 tensions that friction holds apart may differ by less than they are rounded by.
    """
    stay_solved(guides=guides, **tendon, **drag)


@thorough
@given(cases(), some.floats(0.0, 20.0), some.floats(2.0, 8.0), some.booleans())
def test_a_moving_tendon_is_finite_or_told_of(told, case, friction, stiffness, on_one_spot):
    """Any drive with friction to 20, EA to 1e8 N, joints that jump, sites on one spot."""
    more = {"friction": friction}
    if "static_friction" in case.arguments:
        more["static_friction"] = 1.3 * friction
    if "axial_stiffness" in case.arguments:
        more["axial_stiffness"] = 10.0**stiffness
    if on_one_spot:
        spot = re.sub(r'(name="s\d[01]" pos)="[^"]*"', r'\1="0.03 0 0.03"', case.xml)
        case = replace(case, xml=spot)
    model = case.model(**more)
    (sheath,) = sheaths(model)
    told.clear()
    for data in moved(case, model, STEPS):
        scalars, segments, guides, _ = sheath_view(model, data, sheath)
        if diverged(data):
            return
        told_of_it = [message for message in told if "is pushed" not in message]
        if scalars.unsolved:
            (message,) = told_of_it
            assert f"sheath '{sheath}'" in message
        else:
            assert not told_of_it
            assert np.isfinite(segments["tension"]).all()
        assert np.isfinite(data.qpos).all()
        assert (segments["tension"] >= 0.0).all()
        assert np.isfinite(guides["friction_work"]).all()
