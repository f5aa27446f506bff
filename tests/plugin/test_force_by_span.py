"""The force of a tendon that MuJoCo pulls is that of each span's tension on its own length.

    Q = −Σ_j T_j ∂ℓ_j/∂q

on every degree of freedom, as the work of the tensions at the ends of the spans, and Q what
MuJoCo's pull along the whole tendon and the sheath add up to.
"""

import mujoco
import numpy as np
import pytest

from tendon_mj import add_friction, view_sheath
from tendon_mj.plugin import sheaths
from tests.plugin.drawn_spans import pieces_of
from tests.plugin.test_driven import ACTUATORS, SPRING, arm
from tests.rigs import GIVEN, random_pose, rope, sheath_view, sheathed, simulated, spatial, stock

POSES = 5


def posed(model, rng, steps=5):
    """Data some steps behind a random pose, with random controls, evaluated where it is."""
    data = mujoco.MjData(model)
    data.qpos[:] = random_pose(model, rng)
    low, high = model.actuator_ctrlrange.T
    for _ in range(steps):
        data.ctrl[:] = rng.uniform(low, high)
        if data.act.size:
            data.act[:] = rng.uniform(0.1, 0.9, data.act.size)
        mujoco.mj_step(model, data)
    mujoco.mj_forward(model, data)
    return data


def by_the_sheath(plain, data):
    """What the sheaths add to the passive forces of the model without them."""
    other = mujoco.MjData(plain)
    for field in ("time", "qpos", "qvel", "act", "ctrl", "mocap_pos", "mocap_quat"):
        setattr(other, field, getattr(data, field))
    mujoco.mj_forward(plain, other)
    return data.qfrc_passive - other.qfrc_passive


def by_spans(model, data, name, tendon):
    """−Σ T_j ∂ℓ_j/∂q, −T_in ∂L/∂q of the whole tendon, and most that friction takes [N]."""
    by_span, whole = np.zeros(model.nv), np.zeros(model.nv)
    view = view_sheath(model, data, name)
    at_last = sheath_view(model, data, name).state.input_at_last
    tension = view.tension[::-1] if at_last else view.tension
    for piece in pieces_of(model, data, tendon):
        for body, place, force in piece.pulls(tension[piece.segment]):
            mujoco.mj_applyFT(model, data, force, np.zeros(3), place, body, by_span)
    first, count = int(model.ten_J_rowadr[tendon]), int(model.ten_J_rownnz[tendon])
    row = slice(first, first + count)
    whole[model.ten_J_colind[row]] = -view.input_tension * data.ten_J[row]
    return by_span, whole, np.abs(view.tension - view.input_tension).max()


def check(model, plain, seed):
    """Largest relative error over poses, and the largest difference that friction makes [N]."""
    rng, worst, rubbed, pulled = np.random.default_rng(seed), 0.0, 0.0, 0
    for _ in range(POSES):
        data = posed(model, rng)
        assert np.isfinite(data.qpos).all()
        parts = [
            by_spans(model, data, name, model.tendon(sheath.tendon).id)
            for name, sheath in sheaths(model).items()
        ]
        by_span, whole = (sum(part[k] for part in parts) for k in (0, 1))
        scale = np.abs(by_span).max()
        if scale < 1e-3:
            continue  # slack
        pulled += 1
        error = whole + by_the_sheath(plain, data) - by_span
        worst, rubbed = max(worst, np.abs(error).max() / scale), max(rubbed, *(p[2] for p in parts))
    assert pulled > POSES // 2
    return worst, rubbed


@pytest.mark.filterwarnings("ignore::tendon_mj.TendonWarning")  # of muscles over two sites
@pytest.mark.parametrize("input_end", ["first", "last"])
@pytest.mark.parametrize("friction", [0.0, 0.3])
@pytest.mark.parametrize("name", GIVEN)
def test_on_models_of_others(name, friction, input_end):
    model = sheathed(name, friction=friction, input_end=input_end)
    worst, rubbed = check(model, stock(name), seed=1)
    assert worst < 1e-6
    assert rubbed > 0.1 if friction else rubbed == 0.0


@pytest.mark.parametrize("friction", [0.0, 0.3])
@pytest.mark.parametrize("actuator", ["motor", "muscle", "general", "two"])
def test_on_a_tendon_over_sites_and_a_drum(actuator, friction):
    plain = arm(ACTUATORS[actuator], tendon=SPRING, path="a b wheel@s c ball@ d e")
    model = arm(ACTUATORS[actuator], friction, SPRING, path="a b wheel@s c ball@ d e")
    worst, rubbed = check(model, plain, seed=2)
    assert worst < 1e-6
    assert rubbed > 0.1 if friction else rubbed == 0.0


@pytest.mark.parametrize("path", ["a drum@ b", "a b"])
def test_a_second_tendon_on_the_same_path_applies_the_same_force(path):
    drum = '<geom name="drum" type="cylinder" size=".03 .02" euler="90 0 0"/>'
    text = rope(
        "a -.2 0 -.02",
        "b .15 0 -.06",
        path,
        joint='axis="0 1 0" damping=".3"',
        geom='size=".01" pos=".1 0 0"',
        option='gravity="0 0 0"',
        world=drum,
        tendons=spatial("two", path),
        actuator='<motor tendon="t"/><motor tendon="two"/>',
    )
    spec = mujoco.MjSpec.from_string(text)
    add_friction(spec, "*", friction=0.3, extra_bend=1.0)
    model = spec.compile()
    forces = []
    for pulls in ((-20.0, 0.0), (0.0, -20.0)):
        data = simulated(model, 3, forward=True, qpos=-0.6, ctrl=pulls)
        forces.append(data.qfrc_passive - data.qfrc_damper)
    assert np.abs(forces[0]).max() > 1e-2
    np.testing.assert_allclose(*forces, rtol=1e-9)
