"""Mechanisms at limits and equalities, of a stranger, that did not rest."""

from pathlib import Path

import mujoco
import numpy as np
import pytest

from tendon_mj import add_friction

MECHANISMS = Path(__file__).with_name("mechanisms")
LIMITS = [-25.186839145309143, -14.441982812676923, -21.995784888866105]
CONNECT = [-7.682172933591018, 1.1627735864887179]
NOSLIP = [-37.02, -14.64, -0.5007]
STUCK = {"friction": 0.3016, "static_friction": 0.3919, "constant_friction": 0.7328}
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
