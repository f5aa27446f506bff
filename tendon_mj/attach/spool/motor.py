"""Actuators that pull a tendon, moved to the hinge of a spool that winds it in.

A tendon's actuator of gear g applies the force g F along the tendon, which pulls where it is
negative. On the hinge of a spool of radius r, positive where it winds in, the gear

    g_h = −g r

lets the same F turn the spool by the torque r T, with T = −g F. The actuator's velocity stays what
it was for a tendon that does not stretch, and its length, g_h θ in the place of g L, is shorter by
the constant g L₀, with L₀ the tendon's length at `qpos0`. A force that is affine in it,
F = (g₀ + g₁ ℓ + g₂ v) u + b₀ + b₁ ℓ + b₂ v, stays the same with g₀ + g₁ g L₀ and b₀ + b₁ g L₀.
"""

from __future__ import annotations

from typing import NamedTuple

import mujoco

from tendon_mj.errors import UnsuitedTendonError

_GAIN, _BIAS, _DYN, _TRN = mujoco.mjtGain, mujoco.mjtBias, mujoco.mjtDyn, mujoco.mjtTrn
_GAINS = (_GAIN.mjGAIN_FIXED, _GAIN.mjGAIN_AFFINE)
_BIASES = (_BIAS.mjBIAS_NONE, _BIAS.mjBIAS_AFFINE)
_DYNAMICS = (
    _DYN.mjDYN_NONE,
    _DYN.mjDYN_INTEGRATOR,
    _DYN.mjDYN_FILTER,
    _DYN.mjDYN_FILTEREXACT,
)


class Drive(NamedTuple):
    """Settings of an actuator.

    Attributes:
        gear: g.
        gain, bias: first coefficients, g₀ and b₀.
        velocity_bias: b₂, or a damping ratio where it is positive.
        inheritrange: as of `MjsActuator`.
        low, high: ends of ``ctrlrange``.
    """

    gear: float
    gain: float
    bias: float
    velocity_bias: float
    inheritrange: float
    low: float
    high: float


def drive_of(actuator: mujoco.MjsActuator) -> Drive:
    """Settings of an actuator as they are."""
    return Drive(
        float(actuator.gear[0]),
        float(actuator.gainprm[0]),
        float(actuator.biasprm[0]),
        float(actuator.biasprm[2]),
        float(actuator.inheritrange),
        *map(float, actuator.ctrlrange),
    )


def set_drive(
    actuator: mujoco.MjsActuator, drive: Drive, transmission: mujoco.mjtTrn, target: str
) -> None:
    """Let an actuator act on a tendon or a joint."""
    actuator.trntype, actuator.target = transmission, target
    actuator.gear[0], actuator.gainprm[0], actuator.biasprm[0] = drive[:3]
    actuator.biasprm[2], actuator.inheritrange = drive.velocity_bias, drive.inheritrange
    actuator.ctrlrange[:] = drive.low, drive.high


def check_movable(actuator: mujoco.MjsActuator, tendon: str) -> None:
    """Refuse an actuator whose force would not be the same on a spool.

    Raises:
        UnsuitedTendonError: names the actuator and the reason.
    """
    what = ""
    if actuator.plugin.active:
        what = f"is computed by the plugin {actuator.plugin.plugin_name or actuator.plugin.name!r}"
    elif _DYN.mjDYN_MUSCLE == actuator.dyntype or _GAIN.mjGAIN_MUSCLE == actuator.gaintype:
        what = "is a muscle, which pulls by its own length and turns no spool"
    elif actuator.gaintype not in _GAINS:
        what = f"has the gain {actuator.gaintype.name}, which may depend on the tendon's length"
    elif actuator.biastype not in _BIASES:
        what = f"has the bias {actuator.biastype.name}, which may depend on the tendon's length"
    elif actuator.dyntype not in _DYNAMICS:
        what = f"has the dynamics {actuator.dyntype.name}, which may depend on the tendon's length"
    if what:
        raise UnsuitedTendonError(
            f"tendon {tendon!r} is pulled by actuator {actuator.name!r}, which {what}: leave spool "
            "out, and its force is the input tension"
        )


def on_spool(actuator: mujoco.MjsActuator, model: mujoco.MjModel, radius: float) -> Drive:
    """Settings of a tendon's actuator on the hinge of a spool.

    Args:
        actuator: on the tendon.
        model: compiled with it, for the tendon's length and what follows from the model.
        radius: r [m].
    """
    now, k = drive_of(actuator), actuator.id
    offset = now.gear * float(model.tendon_length0[model.actuator_trnid[k, 0]])
    affine = actuator.gaintype == _GAIN.mjGAIN_AFFINE
    biased = actuator.biastype == _BIAS.mjBIAS_AFFINE
    return Drive(
        gear=-now.gear * radius,
        gain=now.gain + (float(actuator.gainprm[1]) * offset if affine else 0.0),
        bias=now.bias + (float(actuator.biasprm[1]) * offset if biased else 0.0),
        # a damping ratio is that of the inertia on the tendon, as MuJoCo computed it
        velocity_bias=float(model.actuator_biasprm[k, 2]),
        inheritrange=0.0,
        low=float(model.actuator_ctrlrange[k, 0]),
        high=float(model.actuator_ctrlrange[k, 1]),
    )
