"""Design of the spool for a tendon: where it is, its inertia, and its motors."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import mujoco
import numpy as np
from numpy.typing import NDArray

from tendon_mj.attach.elasticity import has_spring
from tendon_mj.attach.spool.motor import Drive, check_movable, on_spool
from tendon_mj.attach.spool.spool import Spool
from tendon_mj.errors import UnsuitedTendonError

_Vector = NDArray[np.float64]


class SpoolDesign(NamedTuple):
    """A spool that can be added.

    Attributes:
        tendon: that it winds in.
        body: that carries it, which is that of the site at its input end.
        pos, axis: of its hinge, in the frame of that body [m], [-].
        radius: [m].
        armature: [kg m²].
        damping: [N m s/rad].
        motors: to be moved to it, and what they are to be set to.
        angles: in the model's keyframes [rad].
        warning: where the step does not follow its inertia; else empty.
    """

    tendon: str
    body: mujoco.MjsBody
    pos: _Vector
    axis: _Vector
    radius: float
    armature: float
    damping: float
    motors: list[tuple[mujoco.MjsActuator, Drive]]
    angles: list[float]
    warning: str


def design_spool(
    spec: mujoco.MjSpec,
    tendon: mujoco.MjsTendon,
    name: str,
    spool: Spool,
    at_last: bool,
    axial_stiffness: float,
    strain: float,
    motors: Sequence[mujoco.MjsActuator],
    compiled: Callable[[], mujoco.MjModel],
) -> SpoolDesign:
    """The spool that takes over the actuators of a tendon.

    Args:
        spec: of the tendon.
        tendon: of the spec.
        name: of the tendon, or the one that it will have.
        spool: its parameters.
        at_last: whether the tendon's last site is its input end, and not its first.
        axial_stiffness: EA [N].
        strain: under T_0 [-].
        motors: the actuators on the tendon.
        compiled: returns the compiled spec.

    Raises:
        UnsuitedTendonError: no actuator on the tendon, one that would not pull as before on a
            spool, or a spring of the tendon's own beside it.
    """
    if not motors:
        raise UnsuitedTendonError(
            f"tendon {name!r} has no actuator to turn a spool: leave spool out, and give reel, or "
            "a reel_joint of the model's own"
        )
    for motor in motors:
        check_movable(motor, name)
    if has_spring(tendon):
        raise UnsuitedTendonError(
            f"tendon {name!r} has a spring of its own, which pulls beside its actuators and cannot "
            "behind a spool: set its stiffness to 0, or leave spool out"
        )
    model = compiled()
    data = mujoco.MjData(model)
    _place(model, data)
    start, count = int(data.ten_wrapadr[tendon.id]), int(data.ten_wrapnum[tendon.id])
    points = data.wrap_xpos.reshape(-1, 3)[start : start + count]
    first, second = (-1, -2) if at_last else (0, 1)
    span = points[second] - points[first]
    length = max(float(np.linalg.norm(span)), 1e-3)  # two sites on one spot
    stiffness, step = axial_stiffness / length, float(model.opt.timestep)
    armature = spool.inertia(stiffness, step)
    least = spool.least_inertia(stiffness, step)
    element = model.tendon_num[tendon.id] - 1 if at_last else 0
    site = int(model.wrap_objid[model.tendon_adr[tendon.id] + element])
    turn = data.xmat[model.site_bodyid[site]].reshape(3, 3)
    along = turn.T @ (span / np.linalg.norm(span) if span.any() else np.array([1.0, 0.0, 0.0]))
    across = np.cross(along, np.eye(3)[np.argmin(np.abs(along))])
    across /= np.linalg.norm(across)
    warning = ""
    if armature < least:
        warning = (
            f"the step of {step:g} s does not follow the spool of {name!r} on its tendon: give it "
            f"an armature of {least:.3g} kg m² at least, or take a smaller axial_stiffness or step"
        )
    return SpoolDesign(
        tendon=name,
        body=next(s for s in spec.sites if s.id == site).parent,
        pos=model.site_pos[site] + spool.radius * across,
        axis=np.cross(across, along),
        radius=spool.radius,
        armature=armature,
        damping=spool.damping,
        motors=[(motor, on_spool(motor, model, spool.radius)) for motor in motors],
        angles=_angles(model, data, tendon.id, spool.radius * (1.0 + strain)),
        warning=warning,
    )


def _place(model: mujoco.MjModel, data: mujoco.MjData) -> None:
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    mujoco.mj_tendon(model, data)


def _angles(model: mujoco.MjModel, data: mujoco.MjData, tendon: int, radius: float) -> list[float]:
    """Angle in each keyframe at which the tendon is as tight as at `qpos0` [rad].

    The radius is that of the drum times the stretch of what it winds.
    """
    angles = []
    for key in range(model.nkey):
        mujoco.mj_resetDataKeyframe(model, data, key)
        _place(model, data)
        angles.append(float(model.tendon_length0[tendon] - data.ten_length[tendon]) / radius)
    return angles
