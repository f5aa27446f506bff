"""Friction never adds energy, tension is never negative, unstretched length is conserved."""

import mujoco
import numpy as np
import pytest
from hypothesis import event, given

from tendon_mj.plugin import sheaths
from tests.guarantees.random_tendon import DRIVEN, WOUND, cases, diverged, moved, thorough
from tests.rigs import sheath_view

STEPS = 60
STRAIN = 4e-15  # to which a tension over EA is known, from lengths of which ROUNDING is known
ROUNDING = np.finfo(float).eps
pytestmark = pytest.mark.filterwarnings("ignore::tendon_mj.TendonWarning")


def states(case):
    """The only sheath's state after each step, until MuJoCo finds the model unstable."""
    model = case.model()
    (sheath,) = sheaths(model)
    for data in moved(case, model, STEPS):
        if diverged(data):
            event(f"{case.drive}: unstable")
            return
        assert np.isfinite(data.qpos).all()
        yield sheath_view(model, data, sheath)


def uncertain(segments, guides):
    """Difference of the tensions beside each guide, over EA, that rounding leaves uncertain.

    A tension follows from the length that its segment holds, what passed the guides beside it
    included; across a guide it is multiplied by as much as that holds.
    """
    flow = np.abs(guides["trial_flow"])
    beside = np.concatenate([[0.0], flow]) + np.concatenate([flow, [0.0]])
    strain = STRAIN + 4.0 * ROUNDING * beside / segments["length"]
    holds = np.maximum(guides["static_ratio"], guides["static_ratio_back"])
    return holds * (strain[:-1] + strain[1:])


@thorough
@given(cases())
def test_tension_is_never_negative_and_friction_work_never_falls_at_any_guide(case):
    before = 0.0
    for scalars, segments, guides, _ in states(case):
        assert (segments["tension"] >= 0.0).all()
        finite = np.isfinite(segments["tension"])
        assert finite.all() or scalars.unsolved > 0
        # without a solution tensions are inf, and nothing flows
        tension, flow = np.where(finite, segments["tension"], 0.0), np.abs(guides["trial_flow"])
        force = scalars.law.axial_stiffness * (tension[:-1] + tension[1:])
        if scalars.law.tendon_mass:
            force += scalars.law.tendon_mass * flow / scalars.trial_elapsed**2
        work = guides["friction_work"].copy()
        rounded = scalars.law.axial_stiffness * uncertain(segments, guides) * flow
        assert (work >= before - 1e-12 * force * flow - rounded - 1e-15).all()
        assert (work[guides["is_pulley"] != 0.0] == 0.0).all()
        before = work


@thorough
@given(cases().filter(lambda case: "tendon_mass" not in case.arguments and "RK4" not in case.xml))
def test_friction_takes_from_what_flows(case):
    """(T_i − T_{i+1}) Δs_i ≥ 0: tendon passes a guide from the higher tension to the lower.

    A mass takes tension without rubbing, and Runge-Kutta's last evaluation, whose tensions are
    read here, is not the step's first, whose flow is kept.
    """
    for _, segments, guides, _ in states(case):
        tension, passed = segments["tension"], guides["trial_flow"]
        rounded = 1e-12 * (tension[:-1] + tension[1:]) + uncertain(segments, guides)
        rounded *= np.abs(passed)
        # a flow is a difference of lengths: of a slack tendon it is their rounding
        rounded += np.abs(np.diff(tension)) * ROUNDING * segments["length"].sum()
        within = guides["is_pulley"] == 0.0
        assert (-np.diff(tension) * passed >= -rounded)[within].all()


@thorough
@given(cases(WOUND))
def test_unstretched_length_is_conserved(case):
    total = None
    for scalars, segments, _, _ in states(case):
        now = segments["stored"].sum() + scalars.wound_in + scalars.wound_out
        total = now if total is None else total
        assert now == pytest.approx(total, rel=1e-9)


@thorough
@given(cases(DRIVEN))
def test_without_friction_a_driven_tendon_moves_as_mujocos_own(case):
    law = dict.fromkeys(case.arguments, 0.0)
    rubbing = case.model(**law)
    free = mujoco.MjSpec.from_string(case.xml).compile()
    for one, other in zip(moved(case, rubbing, STEPS), moved(case, free, STEPS), strict=True):
        assert np.array_equal(one.qpos, other.qpos)
