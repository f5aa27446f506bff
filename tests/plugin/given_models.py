"""Models of others in the folder that TENDON_MJ_MODELS names, with friction and without."""

import os
from pathlib import Path

import mujoco
import numpy as np
import pytest

from tendon_mj import add_friction

FOLDER = Path(os.environ.get("TENDON_MJ_MODELS") or "/nowhere")
NAMES = ("arm26", "myoelbow", "aero_hand", "myohand")
GIVEN = [
    pytest.param(
        name,
        marks=pytest.mark.skipif(
            not (FOLDER / f"{name}.xml").is_file(),
            reason=f"TENDON_MJ_MODELS names no folder with {name}.xml",
        ),
    )
    for name in NAMES
]


def stock(name):
    """The model as it was published."""
    return mujoco.MjModel.from_xml_path(str(FOLDER / f"{name}.xml"))


def sheathed(name, **values):
    """The model with a sheath on each tendon that an actuator pulls on."""
    spec = mujoco.MjSpec.from_file(str(FOLDER / f"{name}.xml"))
    on_tendon = mujoco.mjtTrn.mjTRN_TENDON
    tendons = sorted({a.target for a in spec.actuators if a.trntype == on_tendon})
    return add_friction(spec, tendons, **values).compile()


def random_pose(model, rng):
    """A pose with each hinge and slide anywhere in its range, the others at `qpos0`."""
    qpos = model.qpos0.copy()
    hinge_or_slide = model.jnt_type >= mujoco.mjtJoint.mjJNT_SLIDE.value
    for j in np.flatnonzero(hinge_or_slide & model.jnt_limited.astype(bool)):
        qpos[model.jnt_qposadr[j]] = rng.uniform(*model.jnt_range[j])
    return qpos
