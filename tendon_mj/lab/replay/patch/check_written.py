"""A model as it was written, held against what it was to be."""

from __future__ import annotations

import copy
import math
from collections.abc import Mapping, Sequence
from pathlib import Path

import mujoco
import numpy as np
from numpy.typing import NDArray

from tendon_mj.errors import TendonError
from tendon_mj.lab.replay.live_parameters import DRAWN_BEND, EXTRA_BEND
from tendon_mj.lab.replay.parameters import Adjustable
from tendon_mj.models import load_model

_AGREE = 1e-12  # relative; degrees and radians are not the same to the last bit


def check_written(
    made: Path,
    path: Path,
    adjustable: Adjustable,
    parameters: Mapping[str, float],
    muscles: Sequence[int],
) -> None:
    """Hold the file ``made``, as MuJoCo compiles it, against the model that ``path`` is to be.

    ``muscles`` are those whose range of lengths was written.

    Raises:
        TendonError: the file cannot be compiled, or a parameter or number of the model differs.
    """
    try:
        written = load_model(str(made))
    except TendonError as error:
        raise TendonError(str(error).replace(str(made), str(path))) from error
    found = Adjustable(copy.copy(written)).parameters()
    for name, value in parameters.items():
        bend = name.endswith((f".{EXTRA_BEND}", f".{DRAWN_BEND}"))  # a difference of two
        near = {"rel_tol": _AGREE, "abs_tol": _AGREE if bend else 0.0}
        if name not in found or not math.isclose(found[name].value, value, **near):
            got = found[name].value if name in found else "no such parameter"
            raise TendonError(f"{path}: {name} = {value!r} was to be written, it reads {got}")
    mujoco.mj_setConst(adjustable.model, mujoco.MjData(adjustable.model))
    for field in (
        *("qpos0", "body_mass", "body_inertia", "dof_invweight0", "dof_damping", "jnt_stiffness"),
        *("site_pos", "tendon_length0", "actuator_biasprm"),
    ):
        _compare(path, field, getattr(adjustable.model, field), getattr(written, field))
    for field in ("actuator_acc0", "actuator_lengthrange"):
        meant, got = getattr(adjustable.model, field), getattr(written, field)
        _compare(path, field, meant[muscles], got[muscles])
    _compare(path, "gravity", adjustable.model.opt.gravity, written.opt.gravity)
    meant, got = adjustable.model.tendon_lengthspring, written.tendon_lengthspring
    # its own spring, resting where `springref` says
    pulls = adjustable.model.tendon_stiffness > 0.0
    _compare(path, "tendon_lengthspring", meant[pulls], got[pulls])


def _compare(path: Path, field: str, meant: NDArray[np.float64], got: NDArray[np.float64]) -> None:
    if not np.allclose(meant, got, rtol=_AGREE, atol=_AGREE):
        hint = ""
        if field in ("dof_damping", "jnt_stiffness"):
            hint = "; a joint with springdamper has to be in the text, by a name: give it one"
        raise TendonError(f"{path}: {field} of mjModel is not what was to be written{hint}")
