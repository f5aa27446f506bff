"""A tendon's own spring as the elasticity of a cable, and what MuJoCo's constraints do to it."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import mujoco

from tendon_mj.attach.tendon_path import is_limited
from tendon_mj.errors import UnsuitedTendonError


def has_spring(tendon: mujoco.MjsTendon) -> bool:
    """Whether a tendon pulls of itself."""
    return any(float(k) for k in tendon.stiffness)


class Constraints(NamedTuple):
    """Constraints of MuJoCo's that may act along a tendon.

    Attributes:
        equalities: names of the equalities in which it is.
        longest: length at which its limit ends it [m]; None without a limit.
    """

    equalities: tuple[str, ...] = ()
    longest: float | None = None

    def __str__(self) -> str:
        said = [f"equality {name!r}" if name else "an equality" for name in self.equalities]
        return " and ".join(said + ["its limit"] * (self.longest is not None))


def constraints_on(spec: mujoco.MjSpec, tendon: mujoco.MjsTendon) -> Constraints:
    """Constraints that may act along a tendon of a spec."""
    names = tuple(
        equality.name
        for equality in spec.equalities
        if equality.type == mujoco.mjtEq.mjEQ_TENDON
        and tendon.name in (equality.name1, equality.name2)
    )
    longest = float(tendon.range[1]) if is_limited(tendon.limited, tendon.range) else None
    return Constraints(names if tendon.name else (), longest)


def own_elasticity(
    tendon: mujoco.MjsTendon,
    name: str,
    compiled: Callable[[], mujoco.MjModel],
    branches: int = 1,
) -> tuple[float, float]:
    """EA and T_0 [N] equivalent to a tendon's stiffness k and spring length S at `qpos0`.

    EA = k S and T_0 = k (L(qpos0) − S), so that the sheath pulls as the spring did where it pulled.

    Args:
        tendon: of a spec.
        name: of the tendon, for messages.
        compiled: returns the compiled spec, for the lengths of the tendon and its spring.
        branches: of the tendon.

    Raises:
        UnsuitedTendonError: a spring that no tendon of one stiffness and one length is.
    """
    where = f"tendon {name!r}"
    stiffness = [float(k) for k in tendon.stiffness]
    if not any(stiffness):
        raise UnsuitedTendonError(
            f"{where} has no stiffness to take over, and no actuator acts on it: give "
            "axial_stiffness [N] and pretension [N]"
        )
    if not stiffness[0] > 0.0 or any(stiffness[1:]):
        raise UnsuitedTendonError(
            f"{where} has a stiffness that is a polynomial or negative, {stiffness}; a sheath's is "
            "positive and linear: give axial_stiffness [N] and pretension [N]"
        )
    if branches > 1:
        raise UnsuitedTendonError(
            f"{where} runs over pulleys, and its spring is one of all branches together: give "
            "axial_stiffness [N] and pretension [N]"
        )
    model = compiled()
    length = float(model.tendon_length0[tendon.id])
    shortest, longest = (float(x) for x in model.tendon_lengthspring[tendon.id])
    advice = "give axial_stiffness [N] and pretension [N] instead"
    if not longest > 0.0:
        raise UnsuitedTendonError(
            f"{where} has springlength = 0, so no strain is defined: {advice}"
        )
    if 0.0 < shortest < longest:
        raise UnsuitedTendonError(
            f"{where} has a dead band, springlength = {shortest:g} {longest:g} [m]: {advice}"
        )
    if longest > length * (1.0 + 1e-9):
        raise UnsuitedTendonError(
            f"{where} is slack at qpos0 by {longest - length:g} m, which no pretension ≥ 0 says: "
            f"{advice}"
        )
    return stiffness[0] * longest, max(0.0, stiffness[0] * (length - longest))
