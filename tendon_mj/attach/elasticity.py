"""Axial stiffness and pretension equivalent to a tendon's own spring, for a sheath to take over."""

from __future__ import annotations

import mujoco

from tendon_mj.errors import InvalidValueError


def own_elasticity(spec: mujoco.MjSpec, name: str) -> tuple[float, float]:
    """EA and T_0 [N] equivalent to a tendon's stiffness k and spring length S at `qpos0`.

    EA = k S and T_0 = k (L(qpos0) − S), so that the sheath pulls as the spring did where it pulled.

    Args:
        spec: that has the tendon; compiled, not changed.
        name: of the tendon.

    Raises:
        InvalidValueError: a spring that no tendon of one stiffness and one length is.
    """
    where = f"tendon {name!r}"
    stiffness = [float(k) for k in spec.tendon(name).stiffness]
    if not stiffness[0] > 0.0:
        raise InvalidValueError(f"{where} has no stiffness to take over: give axial_stiffness [N]")
    if any(stiffness[1:]):
        raise InvalidValueError(
            f"{where} has a stiffness that is a polynomial, {stiffness}; a sheath's is linear: "
            "give axial_stiffness [N] and pretension [N]"
        )
    model = spec.compile()  # not a copy: MuJoCo's copies drop a plugin that no element refers to
    tendon = model.tendon(name).id
    length = float(model.tendon_length0[tendon])
    shortest, longest = (float(x) for x in model.tendon_lengthspring[tendon])
    advice = "give axial_stiffness [N] and pretension [N] instead"
    if not longest > 0.0:
        raise InvalidValueError(f"{where} has springlength = 0, so no strain is defined: {advice}")
    if 0.0 < shortest < longest:
        raise InvalidValueError(
            f"{where} has a dead band, springlength = {shortest:g} {longest:g} [m]: {advice}"
        )
    if longest > length * (1.0 + 1e-9):
        raise InvalidValueError(
            f"{where} is slack at qpos0 by {longest - length:g} m, which no pretension ≥ 0 says: "
            f"{advice}"
        )
    return stiffness[0] * longest, max(0.0, stiffness[0] * (length - longest))
