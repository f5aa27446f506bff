"""Straight pieces of a tendon's drawn path, from MuJoCo's points alone.

A guide on a geom is a point in the middle of the arc: the span before it is a straight line and the
arc up to that point, the span behind it the rest. An arc lies on its geom, so a span acts on the
bodies by its tension at the two ends of its straight line.
"""

from typing import NamedTuple

import mujoco
import numpy as np

_WRAP = mujoco.mjtWrap


class Piece(NamedTuple):
    """Straight part of a span: segment, divisor of the branch, ends and their bodies."""

    segment: int
    divisor: float
    ends: np.ndarray
    bodies: tuple

    def pulls(self, tension):
        """Body, place and force of a tension at either end."""
        along = self.ends[1] - self.ends[0]
        pull = tension * along / max(np.linalg.norm(along), 1e-12)
        return zip(self.bodies, self.ends, (pull, -pull), strict=True)


def pieces_of(model, data, tendon):
    """Straight pieces of a tendon in the pose at hand, with one guide a geom."""
    first, count = int(model.tendon_adr[tendon]), int(model.tendon_num[tendon])
    kinds, objects = (w[first : first + count] for w in (model.wrap_type, model.wrap_objid))
    points = data.wrap_xpos.reshape(-1, 3)[int(data.ten_wrapadr[tendon]) :]
    touched = data.wrap_obj.reshape(-1)[int(data.ten_wrapadr[tendon]) :]
    pieces, segment, divisor, at, k = [], 0, 1.0, 0, 0

    def add(segment, at, *bodies):
        pieces.append(Piece(segment, divisor, points[at : at + 2].copy(), bodies))

    while k < count - 1:
        site, item = model.site_bodyid[objects[k]], objects[k + 1]
        if kinds[k + 1] == _WRAP.mjWRAP_PULLEY:
            divisor = model.wrap_prm[first + k + 1]
            segment, k, at = segment + 1, k + 2, at + 2
            continue
        if kinds[k + 1] == _WRAP.mjWRAP_SITE:
            add(segment, at, site, model.site_bodyid[item])
            k, at = k + 1, at + 1
        elif touched[at + 1] == item:
            add(segment, at, site, model.geom_bodyid[item])
            add(segment + 1, at + 2, model.geom_bodyid[item], model.site_bodyid[objects[k + 2]])
            segment, k, at = segment + 1, k + 2, at + 3
        else:
            add(segment, at, site, model.site_bodyid[objects[k + 2]])
            segment, k, at = segment + 1, k + 2, at + 1
        if k < count - 1 and kinds[k + 1] != _WRAP.mjWRAP_PULLEY:
            segment += 1
    return pieces
