"""The force of a tendon that MuJoCo pulls is that of each span's tension on its own length.

    Q = −Σ_j T_j ∂ℓ_j/∂q

on every degree of freedom, with ∂ℓ_j/∂q by central differences of lengths that NumPy computes from
the points of the path, and Q what MuJoCo's pull along the whole tendon and the sheath add up to.
"""

import mujoco
import numpy as np
import pytest

from tendon_mj import add_friction, view_sheath
from tendon_mj.plugin import sheaths
from tests.plugin.drawn_spans import span_gradients
from tests.plugin.test_driven import ACTUATORS, SPRING, arm
from tests.rigs import GIVEN, random_pose, rope, sheath_view, sheathed, simulated, spatial, stock

POSES = 5


def whole_length_gradient(model, data, tendon):
    """MuJoCo's ∂L/∂q."""
    first, count = int(model.ten_J_rowadr[tendon]), int(model.ten_J_rownnz[tendon])
    row = np.zeros(model.nv)
    row[model.ten_J_colind[first : first + count]] = data.ten_J[first : first + count]
    return row


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


def by_the_sheath(model, plain, data):
    """What the sheaths add to the passive forces of the model without them."""
    other = mujoco.MjData(plain)
    for field in ("time", "qpos", "qvel", "act", "ctrl", "mocap_pos", "mocap_quat"):
        setattr(other, field, getattr(data, field))
    mujoco.mj_forward(plain, other)
    return data.qfrc_passive - other.qfrc_passive


def spans_and_whole(model, data):
    """−Σ T_j ∂ℓ_j/∂q and −Σ T_in ∂L/∂q over the sheaths, and the dofs on which both are smooth."""
    by_span, whole, rubbed = np.zeros(model.nv), np.zeros(model.nv), 0.0
    smooth = np.ones(model.nv, bool)
    for name, sheath in sheaths(model).items():
        tendon = model.tendon(sheath.tendon).id
        view = view_sheath(model, data, name)
        rows, is_smooth = span_gradients(model, data, tendon, view.tension.size)
        whole_row = whole_length_gradient(model, data, tendon)
        if not is_smooth:  # a geom is touched on one side of the pose only
            smooth &= whole_row == 0.0
            continue
        at_last = sheath_view(model, data, name).state.input_at_last
        by_span -= (view.tension[::-1] if at_last else view.tension) @ rows
        whole -= view.input_tension * whole_row
        rubbed = max(rubbed, np.abs(view.tension - view.input_tension).max())
    return by_span, whole, smooth, rubbed


def check(model, plain, seed):
    """Largest relative error over poses, and the largest difference that friction makes [N]."""
    rng, worst, rubbed, pulled = np.random.default_rng(seed), 0.0, 0.0, 0
    for _ in range(POSES):
        data = posed(model, rng)
        assert np.isfinite(data.qpos).all()
        by_span, whole, smooth, most = spans_and_whole(model, data)
        applied = whole + by_the_sheath(model, plain, data)
        scale = np.abs(by_span).max()
        if scale < 1e-3 or np.count_nonzero(smooth) <= model.nv // 2:
            continue  # slack, or on the edge of a geom
        worst = max(worst, np.abs((applied - by_span)[smooth]).max() / scale)
        rubbed, pulled = max(rubbed, most), pulled + 1
    assert pulled > POSES // 2
    return worst, rubbed


FRICTIONS = [0.0, 0.3]


@pytest.mark.filterwarnings("ignore::tendon_mj.TendonWarning")  # of muscles over two sites
@pytest.mark.parametrize("input_end", ["first", "last"])
@pytest.mark.parametrize("friction", FRICTIONS)
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
