"""Keyframes of a model that gains or loses joints, which MuJoCo only pads or cuts off."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import mujoco


class Keyframe(NamedTuple):
    """What a keyframe states; empty what it does not."""

    qpos: list[float]
    qvel: list[float]
    act: list[float]
    ctrl: list[float]


def keyframes(spec: mujoco.MjSpec) -> list[Keyframe]:
    """What each keyframe of a model states."""
    return [
        Keyframe(list(key.qpos), list(key.qvel), list(key.act), list(key.ctrl)) for key in spec.keys
    ]


def insert_joints(
    spec: mujoco.MjSpec,
    before: Sequence[Keyframe],
    angles: Mapping[str, Sequence[float]],
    speeds: Mapping[str, Sequence[float]] | None = None,
) -> None:
    """Put joints that were added to a model into its keyframes, at rest unless with ``speeds``."""
    if not before:
        return
    _write(spec, [key._replace(qpos=[], qvel=[]) for key in before])
    model = spec.compile()
    for name in sorted(angles, key=lambda name: model.joint(name).id):
        position, velocity = _address(model, name)
        moving = (speeds or {}).get(name, [0.0] * len(before))
        for key, angle, speed in zip(before, angles[name], moving, strict=True):
            key.qpos[position:position] = [angle] if key.qpos else []
            key.qvel[velocity:velocity] = [speed] if key.qvel else []
    _write(spec, before)


def without_joints(spec: mujoco.MjSpec, joints: Sequence[str]) -> list[Keyframe]:
    """Keyframes of a model as they are once these joints are gone."""
    keys = keyframes(spec)
    if keys:
        model = spec.compile()
        for position, velocity in sorted((_address(model, n) for n in joints), reverse=True):
            for key in keys:  # of which these may be empty
                del key.qpos[position : position + 1], key.qvel[velocity : velocity + 1]
    return keys


def restore_keyframes(spec: mujoco.MjSpec, keys: Sequence[Keyframe]) -> None:
    """Write what `without_joints` returned, once all that belongs to these joints is gone, too."""
    if keys and not len(spec.keys):
        # before MuJoCo 3.16: back once compiled, behind as many empty ones or none
        spec.compile()
        for key in list(spec.keys)[: -len(keys)]:
            spec.delete(key)
    _write(spec, keys)


def _write(spec: mujoco.MjSpec, keys: Sequence[Keyframe]) -> None:
    for key, stated in zip(spec.keys, keys, strict=True):
        key.qpos, key.qvel, key.act, key.ctrl = stated


def _address(model: mujoco.MjModel, joint: str) -> tuple[int, int]:
    """Addresses of a joint's position and velocity."""
    element = model.joint(joint)
    return int(element.qposadr[0]), int(element.dofadr[0])
