"""Largest stiffness of a tendon that a time step of a model carries."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence

import mujoco
import numpy as np

from tendon_mj.errors import UnknownNameError
from tendon_mj.plugin import sheaths
from tendon_mj.sheath import Law
from tendon_mj.typing import FloatArray

_SITE = mujoco.mjtWrap.mjWRAP_SITE.value
_ROUNDING = 1e-9  # relative
_STABLE = 4.0  # (ωh)² up to which MuJoCo's integrators carry a spring
_ON_SITE = -1  # in `mjData.wrap_obj`; below it is a pulley


def largest_stiffness(model: mujoco.MjModel, tendon: str) -> float:
    """Largest EA of a sheath on a tendon that a time step of the model carries [N].

        EA = min_j ℓ_j / (h² a_j),   a_j = J_j M⁻¹ J_jᵀ

    A stretch j of tendon that its guides hold, of length ℓ_j between two bodies, is a spring EA/ℓ_j
    on the inertia 1/a_j, with J_j = ∂ℓ_j/∂q. MuJoCo's integrators carry ω² = a_j EA/ℓ_j up to 4/h²
    if it is alone; a quarter of that leaves room for other tendons. A stiffer tendon can ring at
    the pace of the steps; if an actuator pulls it, its guides yield instead.

    Args:
        model: compiled, in its pose `qpos0`.
        tendon: name of a spatial tendon, or of its sheath.

    Returns:
        The stiffness; ``inf`` for a tendon that moves no joint.

    Raises:
        UnknownNameError: no such tendon, with the nearest name.
    """
    names = [model.tendon(k).name for k in range(model.ntendon)]
    known = sheaths(model)
    if tendon not in names and tendon in known:
        tendon = known[tendon].tendon
    if tendon not in names:
        raise UnknownNameError("tendon", tendon, names, "largest_stiffness")
    return stiffness_limits(model, [names.index(tendon)])[0]


def stiffness_limits(
    model: mujoco.MjModel, tendons: Sequence[int], *, damped: bool = False
) -> list[float]:
    """`largest_stiffness` of several spatial tendons, by their ids; ``damped`` as of `_inertia`."""
    data, inertia = _inertia(model, damped=damped)
    limits = []
    for tendon in tendons:
        limit = np.inf
        for length, jacobian in _straight_spans(model, data, tendon):
            mobility = float(jacobian @ np.linalg.solve(inertia, jacobian))
            if mobility > 0.0:
                limit = min(limit, length / (model.opt.timestep**2 * mobility))
        limits.append(limit)
    return limits


def _inertia(
    model: mujoco.MjModel, *, damped: bool, step: float = 0.0
) -> tuple[mujoco.MjData, FloatArray]:
    """M in the pose `qpos0`, or M + h B/2 if it is ``damped``, with the data of that.

    h is the model's own step unless another one is given.

    That is the inertia of a motion that changes its sense from step to step where the integrator
    takes the damping B implicitly: (M + h B) v⁺ = M v⁻ + h f with v⁻ = −v⁺.
    """
    explicit = model.opt.integrator == mujoco.mjtIntegrator.mjINT_RK4
    damping = np.maximum(model.dof_damping, 0.0) * (damped and not explicit)
    data = mujoco.MjData(model)
    mujoco.mj_fwdPosition(model, data)
    inertia, unit = np.zeros((model.nv, model.nv)), np.eye(model.nv)
    for k in range(model.nv):
        mujoco.mj_mulM(model, data, inertia[k], unit[k])
    return data, inertia + 0.5 * (step or model.opt.timestep) * np.diag(damping)


def step_warning(
    model: mujoco.MjModel, tendon: int, stiffness: float, *, driven: bool = False
) -> str:
    """Sentence on an EA that a step does not carry; empty if it does.

    With more, a wound tendon is unstable, and the guides of one that is ``driven`` yield.
    """
    step, times = model.opt.timestep, 1.0 if driven else _STABLE
    largest = times * stiffness_limits(model, [tendon], damped=not driven)[0]
    if stiffness <= largest * (1.0 + _ROUNDING):
        return ""
    undamped = times * stiffness_limits(model, [tendon])[0]
    shorter = f"{_rounded_down(step * math.sqrt(undamped / stiffness)):.2g} s"
    if driven:
        return (
            f"a time step of {step:g} s carries {largest:.2g} N of an axial stiffness of"
            f" {stiffness:.4g} N, and the guides yield for the rest: take a step of {shorter}, or"
            " leave the axial stiffness out"
        )
    return (
        f"an axial stiffness of {stiffness:.4g} N is more than a time step of {step:g} s carries,"
        f" {largest:.2g} N, and the tendon may ring from step to step: take a step of {shorter}, or"
        " a softer tendon"
    )


def _rounded_down(number: float) -> float:
    """A number of two digits that is not larger."""
    digit = 10.0 ** (math.floor(math.log10(number)) - 1)
    return math.floor(number / digit) * digit


def drums_warning(
    model: mujoco.MjModel, drums: Sequence[tuple[str, float]], law: Law, *, damped_by_step: bool
) -> str:
    """Sentence on cables on drums that a step does not carry; empty if it does.

    ``drums`` are joints with r²/ℓ of each drum, of radius r, on them, ℓ being the length of cable
    up to the next guide. Where that guide holds it is a spring (EA + 2c/h) r²/ℓ on the joint, with
    the axial damping c. A step carries the largest eigenvalue of all these with M up to 4/h².
    ``damped_by_step``: whether c is in proportion to the step.
    """
    springs = np.zeros(model.nv)
    for joint, spring in drums:
        springs[model.joint(joint).dofadr] += spring

    def share_of(step: float) -> tuple[float, FloatArray]:
        """Stiffness over that which a step carries, and the motion that it is of."""
        inertia = _inertia(model, damped=True, step=step)[1]
        modes = np.linalg.eig(np.linalg.solve(inertia, np.diag(springs)))
        fastest = int(np.argmax(modes.eigenvalues.real))
        of_damping = model.opt.timestep if damped_by_step else step
        stiffness = law.axial_stiffness + 2.0 * law.axial_damping / of_damping
        share = step**2 * stiffness * float(modes.eigenvalues[fastest].real) / _STABLE
        return share, np.abs(modes.eigenvectors[:, fastest])

    share, motion = share_of(model.opt.timestep)
    if share <= 1.0 + _ROUNDING:
        return ""
    step, too_stiff = model.opt.timestep, share
    while too_stiff > 1.0 + _ROUNDING:  # in a shorter step what is damped has less inertia
        step = _rounded_down(step / math.sqrt(too_stiff))
        too_stiff, _ = share_of(step)
    joint = model.joint(model.dof_jntid[int(np.argmax(motion))]).name
    return (
        f"a time step of {model.opt.timestep:g} s does not carry cables of"
        f" {law.axial_stiffness:.4g} N on joint {joint!r}, which are {share:.3g} times as stiff as"
        " they may be and can ring from step to step: take a softer or longer cable, more armature"
        f" at the joint, or a step of {step:.2g} s"
    )


def _straight_spans(
    model: mujoco.MjModel, data: mujoco.MjData, tendon: int
) -> list[tuple[float, FloatArray]]:
    """ℓ and ∂ℓ/∂q of the straight stretches of a path between two bodies."""
    start, count = data.ten_wrapadr[tendon], data.ten_wrapnum[tendon]
    points = data.wrap_xpos.reshape(-1, 3)[start : start + count]
    first = model.tendon_adr[tendon]
    path = slice(first, first + model.tendon_num[tendon])
    sites = model.wrap_objid[path][model.wrap_type[path] == _SITE]
    at_sites = iter(model.site_bodyid[sites])
    bodies = [  # −1 for a pulley, where the path breaks off
        int(model.geom_bodyid[on] if on >= 0 else next(at_sites) if on == _ON_SITE else -1)
        for on in data.wrap_obj.ravel()[start : start + count]
    ]
    spans = []
    for k, (near, far) in enumerate(itertools.pairwise(bodies)):
        way = points[k + 1] - points[k]
        length = float(np.linalg.norm(way))
        if near < 0 or far < 0 or near == far or length == 0.0:
            continue
        moves = np.zeros((2, 3, model.nv))
        for end, body in enumerate((near, far)):
            mujoco.mj_jac(model, data, moves[end], None, points[k + end], body)
        spans.append((length, way @ (moves[1] - moves[0]) / length))
    return spans
