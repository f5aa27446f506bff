"""Keeps the spring of a tendon in the model while a sheath has its place.

It is kept as `<custom><text name="<tendon>.tendon_mj_spring" data="…"/>`: the three coefficients of
the stiffness and the two ends of ``springlength``. Copies of a spec and MJCF files keep a text
digit for digit, and `attach` gives it the tendon's prefix or suffix.
"""

from __future__ import annotations

import mujoco

_MARK = ".tendon_mj_spring"
_NONE = [0.0, 0.0, 0.0, -1.0, -1.0]  # no stiffness, and a length that follows from qpos0


def spring_of(tendon: mujoco.MjsTendon) -> list[float]:
    """Coefficients of a tendon's stiffness and the ends of its ``springlength``."""
    return [float(x) for x in (*tendon.stiffness, *tendon.springlength)]


def has_spring(tendon: mujoco.MjsTendon) -> bool:
    """Whether a tendon pulls of itself."""
    return any(float(k) for k in tendon.stiffness)


def keep_spring(spec: mujoco.MjSpec, tendon: mujoco.MjsTendon, spring: list[float]) -> None:
    """Note a spring in the model, and take it off the tendon."""
    _take_note(spec, tendon)  # one that was left behind
    if spring != _NONE:
        spec.add_text(name=f"{tendon.name}{_MARK}", data=" ".join(map(repr, spring)))
    _set(tendon, _NONE)


def give_spring_back(spec: mujoco.MjSpec, tendon: mujoco.MjsTendon) -> None:
    """Put the spring that was noted back on a tendon that has had none since."""
    spring = _take_note(spec, tendon)
    if spring and not has_spring(tendon):
        _set(tendon, spring)


def spring_note(tendon: str) -> str:
    """Name of the text that keeps a tendon's spring."""
    return tendon + _MARK


def _take_note(spec: mujoco.MjSpec, tendon: mujoco.MjsTendon) -> list[float]:
    """The spring that was noted, if one was; its note is deleted."""
    for text in spec.texts:
        if _MARK in text.name and text.name.replace(_MARK, "", 1) == tendon.name:
            spring = [float(x) for x in text.data.split()]
            spec.delete(text)
            return spring
    return []


def _set(tendon: mujoco.MjsTendon, spring: list[float]) -> None:
    tendon.stiffness[:] = spring[:3]
    tendon.springlength[:] = spring[3:]
