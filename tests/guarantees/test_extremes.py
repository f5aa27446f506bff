"""Sheaths at the ends of what can be given: finite, solved, or told by name."""

import re
from dataclasses import replace

import mujoco
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as some

from tendon_mj.engine import sheaths
from tests.engine.models import fixed_sheaths, sheath_view, unpacked, warnings_of_ours
from tests.guarantees.random_tendon import cases, diverged, moved, thorough

STEPS = 60
LENGTH = 0.5  # [m]
DRAGS = (  # what sliding itself takes
    {"viscous_friction": 1e-3},
    {"viscous_friction": 1e3},
    {"tendon_mass": 1e-3},
    {"viscous_friction": 1.0, "tendon_mass": 1.0},
)
pytestmark = pytest.mark.filterwarnings("ignore::tendon_mj.TendonWarning")


@pytest.fixture(autouse=True, scope="module")
def told():
    """Warnings of ours that MuJoCo was given."""
    with warnings_of_ours() as messages:
        yield messages


def stay_solved(loss, bend, stiffness, guides, pretension, strain, seed, **drag):
    """Drive a tendon between fixed ends to and fro: each step is solved, each tension finite."""
    law = {
        "bend": bend,
        "friction": loss / bend,
        "guides": max(guides, int(bend / 3.0) + 1),  # a guide turns by π at most
        "axial_stiffness": 10.0**stiffness,
        "pretension": pretension,
        "length": LENGTH,
        **drag,
    }
    model = fixed_sheaths([law])
    data = mujoco.MjData(model)
    rng = np.random.default_rng(seed)
    for _ in range(STEPS):
        data.ctrl[0] = strain * LENGTH * rng.uniform(-1.0, 1.0)
        mujoco.mj_step(model, data)
        scalars, segments, _ = unpacked(model, data, "sheath0")
        assert scalars.unsolved == 0
        assert np.isfinite(segments["tension"]).all()
        assert (segments["tension"] >= 0.0).all()


tendons = {
    "loss": some.floats(0.0, 20.0),
    "bend": some.floats(0.05, 100.0),
    "stiffness": some.floats(2.0, 8.0),
    "pretension": some.sampled_from([0.0, 1e-6, 1.0, 100.0]),
    "strain": some.sampled_from([1e-9, 1e-4, 1e-2]),
    "seed": some.integers(0, 2**32 - 1),
}


@thorough
@given(guides=some.integers(1, 512), **tendons)
def test_a_tendon_between_fixed_ends_is_solved(guides, **tendon):
    """λ to 20, EA from 1e2 to 1e8 N, to 512 guides, slack and tight again."""
    stay_solved(guides=guides, **tendon)


@thorough
@given(guides=some.integers(1, 64), drag=some.sampled_from(DRAGS), **tendons)
def test_a_viscous_or_heavy_tendon_between_fixed_ends_is_solved(guides, drag, **tendon):
    """The same to 64 guides where sliding itself takes tension."""
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
        case = replace(
            case, xml=re.sub(r'(name="s\d1" pos)="[^"]*"', r'\1="0.03 0 0.03"', case.xml)
        )
        case = replace(
            case, xml=re.sub(r'(name="s\d0" pos)="[^"]*"', r'\1="0.03 0 0.03"', case.xml)
        )
    model = case.model(**more)
    (sheath,) = sheaths(model)
    told.clear()
    for data in moved(case, model, STEPS):
        scalars, segments, guides, _ = sheath_view(model, data, sheath)
        if diverged(data):
            return
        if scalars.unsolved:
            (message,) = told
            assert f"sheath '{sheath}'" in message
        else:
            assert not told
            assert np.isfinite(segments["tension"]).all()
        assert np.isfinite(data.qpos).all()
        assert (segments["tension"] >= 0.0).all()
        assert np.isfinite(guides["friction_work"]).all()
