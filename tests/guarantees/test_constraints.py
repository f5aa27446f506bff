"""Mechanisms that limits and equalities hold rest, if they do without friction."""

import copy
from pathlib import Path

import mujoco
import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as some

from tendon_mj import add_friction, view_sheath
from tests.guarantees.random_tendon import thorough
from tests.guarantees.test_rest import tree

pytestmark = pytest.mark.filterwarnings("ignore::tendon_mj.TendonWarning")
MECHANISMS = Path(__file__).with_name("mechanisms")
LIMITS = [-25.186839145309143, -14.441982812676923, -21.995784888866105]
CONNECT = [-7.682172933591018, 1.1627735864887179]
NOSLIP = [-37.02, -14.64, -0.5007]
STUCK = {"friction": 0.3016, "static_friction": 0.3919, "constant_friction": 0.7328}
TIP = [0.1, 0.0, 0.0]  # of a link
DAMPING = [0.146651643676016, 0.1849085942001941, 0.18969071301571633, 0.2677986536692466]


@pytest.mark.parametrize(
    ("name", "control", "damping", "law", "steps"),
    [
        ("joint_limits", LIMITS, None, {"friction": 0.01}, 4000),
        ("joint_limits", LIMITS, None, {"friction": 0.02}, 4000),
        ("connect", CONNECT, DAMPING, {"friction": 0.0357}, 10000),
        ("connect", CONNECT, DAMPING, {"friction": 0.0357, "static_friction": 0.0464}, 10000),
        ("noslip", NOSLIP, None, STUCK, 5000),
    ],
)
def test_a_mechanism_that_constraints_hold_rests(name, control, damping, law, steps):
    spec = mujoco.MjSpec.from_file(str(MECHANISMS / f"{name}.xml"))
    model = add_friction(spec, "*", **law).compile()
    data = mujoco.MjData(model)
    data.ctrl[:] = control
    if damping is not None:
        model.dof_damping[:] = damping
    mujoco.mj_step(model, data, steps)
    sheaths = [f"{model.tendon(k).name}_output_tension" for k in range(model.ntendon)]
    fastest, tensions = 0.0, []
    for _ in range(100):
        mujoco.mj_step(model, data)
        fastest = max(fastest, np.abs(data.qvel).max())
        tensions.append([data.sensor(name).data[0] for name in sheaths])
    assert fastest < 1e-6
    assert np.ptp(tensions, axis=0).max() < 1e-4 * np.max(tensions)


def connect(k, other):
    """Arguments of an equality that joins the tip of a link to another one, or to the world."""
    names = {"name1": f"link{k}", "name2": f"link{other}" if other != k else "world"}
    return {"type": mujoco.mjtEq.mjEQ_CONNECT, "objtype": mujoco.mjtObj.mjOBJ_BODY, **names}


def couple(k, other):
    """Arguments of an equality that turns a joint with another one, or holds it where it is."""
    names = {"name1": f"joint{k}", "name2": f"joint{other}" if other != k else ""}
    return {"type": mujoco.mjtEq.mjEQ_JOINT, **names}


def held(model, limits, pose):
    """A simulation in a pose in which joints are at limits, and equalities are met."""
    data = mujoco.MjData(model)
    model.jnt_range[:] = np.where(limits[:, None], np.add.outer(pose, [-2.0, -0.02]), [-9.0, 9.0])
    model.qpos_spring[:] = data.qpos[:] = pose
    mujoco.mj_forward(model, data)
    for k in range(model.neq):
        one, other = model.eq_obj1id[k], model.eq_obj2id[k]
        if model.eq_type[k] == mujoco.mjtEq.mjEQ_CONNECT:
            point = data.xpos[one] + data.xmat[one].reshape(3, 3) @ TIP
            frame = data.xmat[other].reshape(3, 3)
            model.eq_data[k, :6] = *TIP, *(frame.T @ (point - data.xpos[other]))
        else:
            model.eq_data[k, :2] = pose[one], 0.7 * (other >= 0)
            model.eq_data[k, 0] -= model.eq_data[k, 1] * pose[other]
    return data


def speed_at_rest(model, limits, pose, pulls, factor=1.0):
    """Largest velocity of a mechanism after 20 s, at a multiple of its step; inf if it fails."""
    model = copy.copy(model)
    model.opt.timestep *= factor
    data = held(model, limits, pose)
    data.ctrl[:] = -pulls
    mujoco.mj_step(model, data, round(20.0 / model.opt.timestep))
    return np.inf if data.warning.number.any() else np.abs(data.qvel).max()


@thorough
@given(
    seed=some.integers(0, 2**32 - 1),
    links=some.integers(1, 6),
    tendons=some.sampled_from([1, 2, 5, 12]),
    step=some.sampled_from([1e-3, 2e-3, 5e-3, 1e-2]),
    integrator=some.sampled_from([0, 2, 3]),
    limited=some.integers(0, 2**6 - 1),
    equalities=some.integers(0, 2),
)
def test_what_limits_and_equalities_hold_rests(
    seed, links, tendons, step, integrator, limited, equalities
):
    rng = np.random.default_rng(seed)
    spec = tree(rng, links, tendons, step, integrator)
    for joint in spec.joints:
        joint.limited, joint.range = True, [-9.0, 9.0]
        joint.damping[0] = rng.uniform(0.02, 0.1)
    for _ in range(equalities):
        k, other = rng.integers(links, size=2)
        spec.add_equality(**rng.choice([connect(k, other), couple(k, other)]))
    pose, pulls = rng.uniform(-0.8, 0.8, links), rng.uniform(1.0, 20.0, tendons)
    friction = rng.uniform(0.02, 0.6)
    stock, model = spec.compile(), add_friction(spec, "*", friction=friction).compile()
    chosen = np.array([limited >> k & 1 for k in range(links)], bool)
    # not on the verge of what MuJoCo can resolve without friction, as jammed linkages are
    assume(max(speed_at_rest(stock, chosen, pose, pulls, factor) for factor in (1.0, 2.0)) < 1e-6)
    data = held(model, chosen, pose)
    data.ctrl[:] = -pulls
    mujoco.mj_step(model, data, round(20.0 / step))
    views = [view_sheath(model, data, f"t{t}") for t in range(tendons)]
    outputs, speed = [], 0.0
    for _ in range(100):
        mujoco.mj_step(model, data)
        outputs.append([float(view.output_tension) for view in views])
        speed = max(speed, np.abs(data.qvel).max())
    assert speed < 1e-4
    assert not data.warning.number.any()
    assert np.ptp(outputs, axis=0).max() < 1e-4 * np.max(outputs)
