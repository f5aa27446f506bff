"""Lengths of the spans of a tendon along its drawn path, computed from MuJoCo's points alone.

A guide on a geom is taken as a point of the geom, in the middle of the arc in the pose at hand: the
span before it is a straight line and the arc up to that point, the span behind it the rest. Where
the tangent points move, the length along both stays the same to first order.
"""

from typing import NamedTuple

import mujoco
import numpy as np

_WRAP = mujoco.mjtWrap
_ONE_POINT = 1e-9  # [m]


class Piece(NamedTuple):
    """Part of a span: a straight line or a half of an arc.

    Attributes:
        segment: that it is part of.
        divisor: of the branch.
        first, second: points of the path, from the tendon's first on.
        geom: on which it ends or begins as an arc, −1 for a straight line.
        middle: of the arc in the frame of the geom [m].
        direction: of the tendon there, as arc length and way along the axis [-].
    """

    segment: int
    divisor: float
    first: int
    second: int
    geom: int = -1
    middle: tuple = ()
    direction: tuple = ()


def points_of(data, tendon):
    """(k, 3) points of the path, and the geom that each lies on, −1 for none."""
    start, count = int(data.ten_wrapadr[tendon]), int(data.ten_wrapnum[tendon])
    touched = data.wrap_obj.reshape(-1)[start : start + count]
    return data.wrap_xpos.reshape(-1, 3)[start : start + count], touched


def _local(data, geom, point):
    return data.geom_xmat[geom].reshape(3, 3).T @ (point - data.geom_xpos[geom])


def _turn(p, q):
    """Angle about the axis of a cylinder from p to q [rad]."""
    return np.arctan2(p[0] * q[1] - p[1] * q[0], p[0] * q[0] + p[1] * q[1])


def pieces_of(model, data, tendon):
    """What the spans of a tendon are made of in the pose at hand, with one guide a geom."""
    first, count = int(model.tendon_adr[tendon]), int(model.tendon_num[tendon])
    kinds, objects = model.wrap_type[first : first + count], model.wrap_objid[first : first + count]
    points, touched = points_of(data, tendon)
    pieces, segment, divisor, at, k = [], 0, 1.0, 0, 0
    while k < count - 1:
        kind = kinds[k + 1]
        if kind == _WRAP.mjWRAP_PULLEY:
            divisor = model.wrap_prm[first + k + 1]
            segment, k, at = segment + 1, k + 2, at + 2
            continue
        if kind == _WRAP.mjWRAP_SITE:
            pieces.append(Piece(segment, divisor, at, at + 1))
            k, at = k + 1, at + 1
        elif touched[at + 1] == objects[k + 1]:
            pieces += _around(model, data, kind, objects[k + 1], points, segment, divisor, at)
            segment, k, at = segment + 1, k + 2, at + 3
        else:
            pieces.append(Piece(segment, divisor, at, at + 1))
            segment, k, at = segment + 1, k + 2, at + 1
        if k < count - 1 and kinds[k + 1] != _WRAP.mjWRAP_PULLEY:
            segment += 1
    return pieces


def _around(model, data, kind, geom, points, segment, divisor, at):
    p, q = (_local(data, geom, points[at + i]) for i in (1, 2))
    before, behind = (
        Piece(segment, divisor, at, at + 1),
        Piece(segment + 1, divisor, at + 2, at + 3),
    )
    if np.linalg.norm(q - p) < _ONE_POINT:
        return [
            before._replace(geom=geom, middle=tuple(p)),
            behind._replace(geom=geom, middle=tuple(p)),
        ]
    ahead = data.geom_xmat[geom].reshape(3, 3).T @ (points[at + 1] - points[at])
    if kind == _WRAP.mjWRAP_CYLINDER:
        sense = np.sign(p[0] * ahead[1] - p[1] * ahead[0])
        turn = (sense * _turn(p, q)) % (2 * np.pi)
        half, rise = sense * turn / 2.0, q[2] - p[2]
        turned = np.array([[np.cos(half), -np.sin(half)], [np.sin(half), np.cos(half)]]) @ p[:2]
        middle = np.array([*turned, p[2] + rise / 2.0])
        way = np.array([2.0 * half * model.geom_size[geom, 0], rise])
    else:
        along = ahead - p * (ahead @ p) / (p @ p)
        along *= np.linalg.norm(p) / np.linalg.norm(along)
        turn = np.arctan2(q @ along, q @ p) % (2 * np.pi)
        middle = np.cos(turn / 2.0) * p + np.sin(turn / 2.0) * along
        way = None
    direction = () if way is None else tuple(way / np.linalg.norm(way))
    arcs = (
        Piece(segment, divisor, at + 1, -1, geom, tuple(middle), direction),
        Piece(segment + 1, divisor, -1, at + 2, geom, tuple(middle), direction),
    )
    return [before, arcs[0], arcs[1], behind]


def length_of(model, data, tendon, piece):
    """Length of a piece in another pose, with the guide where it is on its geom [m]."""
    points, _ = points_of(data, tendon)
    if piece.geom < 0:
        return np.linalg.norm(points[piece.second] - points[piece.first])
    middle = np.array(piece.middle)
    if piece.first >= 0 and piece.second >= 0:  # inside the geom, where it bends at one point
        place = data.geom_xpos[piece.geom] + data.geom_xmat[piece.geom].reshape(3, 3) @ middle
        on_geom = (piece.first, piece.second)
        far = on_geom[0] if points_of(data, tendon)[1][on_geom[0]] < 0 else on_geom[1]
        return np.linalg.norm(points[far] - place)
    end = piece.first if piece.first >= 0 else piece.second
    p = _local(data, piece.geom, points[end])
    sign = -1.0 if piece.first >= 0 else 1.0
    if piece.direction:
        way = model.geom_size[piece.geom, 0] * _turn(middle, p), p[2] - middle[2]
        return sign * np.array(way) @ np.array(piece.direction)
    turn = np.arctan2(np.linalg.norm(np.cross(p, middle)), p @ middle)
    return model.geom_size[piece.geom, 0] * turn


def span_gradients(model, data, tendon, segments, step=1e-6):
    """∂ℓ_j/∂q over the divisor of its branch, one row a segment, and whether they are smooth."""
    pieces = pieces_of(model, data, tendon)
    rows = np.zeros((segments, model.nv))
    _, touched = points_of(data, tendon)
    other, smooth = mujoco.MjData(model), True
    for i in range(model.nv):
        for way in (step, -step):
            nudge = np.zeros(model.nv)
            nudge[i] = way
            qpos = data.qpos.copy()
            mujoco.mj_integratePos(model, qpos, nudge, 1.0)
            other.qpos[:], other.mocap_pos[:] = qpos, data.mocap_pos
            mujoco.mj_kinematics(model, other)
            mujoco.mj_comPos(model, other)
            mujoco.mj_tendon(model, other)
            now = points_of(other, tendon)[1]
            if now.shape != touched.shape or (now != touched).any():
                smooth = False
                continue
            for piece in pieces:
                length = length_of(model, other, tendon, piece)
                rows[piece.segment, i] += np.sign(way) * length / (2.0 * step * piece.divisor)
    return rows, smooth
