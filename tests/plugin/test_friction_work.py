"""What friction takes on driven tendons: never less than nothing, at any guide, on any model."""

import mujoco
import numpy as np
import pytest

from tendon_mj import view_sheath
from tendon_mj.plugin import sheaths
from tests.plugin.test_driven import ACTUATORS, SPRING, arm, controls
from tests.rigs import GIVEN, segment_lengths, sheath_view, sheathed, simulated

SECONDS = 2.0
ROUNDED = 1e-12  # of the tension times the slip that it is the product of


@pytest.mark.filterwarnings("ignore::tendon_mj.TendonWarning")  # of muscles over two sites
@pytest.mark.parametrize("friction", [0.1, 0.4])
@pytest.mark.parametrize("name", GIVEN)
def test_friction_takes_work_at_every_guide_of_every_tendon(name, friction):
    model = sheathed(name, friction=friction)
    data = simulated(model)
    views = {sheath: sheath_view(model, data, sheath) for sheath in sheaths(model)}
    before = dict.fromkeys(views, 0.0)
    for row in controls(model, SECONDS, seed=3):
        data.ctrl[:] = row
        mujoco.mj_step(model, data)
        for sheath, (_, segments, guides, _) in views.items():
            tension = segments["tension"]
            passed, mean = guides["trial_flow"], 0.5 * (tension[:-1] + tension[1:])
            taken = -np.diff(tension) * passed
            assert (taken >= -ROUNDED * mean * np.abs(passed)).all(), sheath
            work = guides["friction_work"].copy()
            assert (work >= before[sheath]).all(), sheath
            assert np.abs(work - before[sheath] - taken).max(initial=0.0) < 1e-9
            before[sheath] = work
    assert np.isfinite(data.qpos).all()
    assert sum(np.sum(work) for work in before.values()) > 1e-3
    assert not any(state.unsolved for state, *_ in views.values())


def elastic_energy(stiffness, tension, lengths):
    """U = Σ EA/2 ε² s of the segments behind the first, which takes in any length."""
    strain = tension / stiffness
    energies = 0.5 * stiffness * strain**2 * lengths / (1.0 + strain)
    return float(energies[1:].sum())


def balance(actuator, stiffness, step):
    """Work put in, what became of it, and how much work there was [J]."""
    option = f'timestep="{step}"'
    model = arm(ACTUATORS[actuator], 0.3, SPRING, "a b c e", option, axial_stiffness=stiffness)
    data = simulated(model)
    put_in = arrived = moved = 0.0
    lengths, tension = segment_lengths(model, data), view_sheath(model, data, "t").tension
    stored = elastic_energy(stiffness, tension, lengths)
    for row in controls(model, 1.0, seed=5):
        data.ctrl[:] = row
        mujoco.mj_step(model, data)
        mujoco.mj_kinematics(model, data)
        tension = view_sheath(model, data, "t").tension
        passed = sheath_view(model, data).guides["trial_flow"]
        before, lengths = lengths, segment_lengths(model, data)
        change = lengths - before  # the force of a step's pose acts until the next
        put_in += tension[0] * (passed[0] * (1.0 + tension[0] / stiffness) - change[0])
        arrived -= tension @ change
        moved += np.abs(tension @ change)
    stored = elastic_energy(stiffness, tension, lengths) - stored
    return put_in, arrived + stored, view_sheath(model, data, "t").friction_work.sum(), moved


@pytest.mark.parametrize("actuator", ["motor", "position", "muscle", "general", "two"])
@pytest.mark.parametrize("stiffness", [1e4, 1e5])
def test_what_is_put_in_arrives_is_stored_or_is_taken_by_friction(actuator, stiffness):
    """∫ T_in dx = −Σ ∫ T_j dℓ_j + ΔU + W, with x the tendon that has been drawn in at the input."""
    for step, most in ((4e-4, 0.01), (1e-4, 0.003)):
        put_in, arrived, taken, moved = balance(actuator, stiffness, step)
        assert taken > 0.02 * moved
        lost = (put_in - arrived - taken) / moved
        assert lost > -most, "nothing is created"
        # a slack tendon that is taken up loses more, as what is pulled tight with a jerk does
        assert lost < most or actuator == "position"
