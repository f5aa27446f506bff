"""Keyframes of a model that gains or loses joints; MuJoCo only pads them or cuts them off."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

import mujoco

Keyframe = tuple[list[float], list[float]]  # positions and velocities


def keyframes(spec: mujoco.MjSpec) -> list[Keyframe]:
    """Positions and velocities of each keyframe, empty where it does not say."""
    return [(list(key.qpos), list(key.qvel)) for key in spec.keys]


def insert_joints(
    spec: mujoco.MjSpec,
    before: Sequence[Keyframe],
    angles: Mapping[str, Sequence[float]],
) -> None:
    """Put joints that were added to a model into its keyframes, at rest.

    Args:
        spec: with the joints, compiled where it has keyframes.
        before: its keyframes without them.
        angles: of each of the joints, by its name, in each keyframe.
    """
    if not before:
        return
    write_keyframes(spec, [([], [])] * len(before))
    model = spec.compile()
    places = sorted((*_place(model, name), name) for name in angles)
    for k, (qpos, qvel) in enumerate(before):
        for position, velocity, name in places:
            if qpos:
                qpos.insert(position, angles[name][k])
            if qvel:
                qvel.insert(velocity, 0.0)
    write_keyframes(spec, before)


def without_joints(spec: mujoco.MjSpec, joints: Collection[str]) -> list[Keyframe]:
    """Keyframes of a model as they are once these joints are gone."""
    found = keyframes(spec)
    if not found:
        return found
    model = spec.compile()
    places = sorted((_place(model, name) for name in joints), reverse=True)
    for qpos, qvel in found:
        for position, velocity in places:
            if qpos:
                del qpos[position]
            if qvel:
                del qvel[velocity]
    return found


def write_keyframes(spec: mujoco.MjSpec, found: Sequence[Keyframe]) -> None:
    """Write positions and velocities of each keyframe."""
    for key, (qpos, qvel) in zip(spec.keys, found, strict=True):
        key.qpos, key.qvel = qpos, qvel


def _place(model: mujoco.MjModel, joint: str) -> tuple[int, int]:
    """Where a joint's position and velocity are."""
    found = model.joint(joint)
    return int(found.qposadr[0]), int(found.dofadr[0])
