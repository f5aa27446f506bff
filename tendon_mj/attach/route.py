"""Routes a sheath as a row of sites, one a guide."""

from __future__ import annotations

from collections.abc import Sequence

import mujoco
import numpy as np
from numpy.typing import ArrayLike

from tendon_mj.errors import InvalidValueError, UnknownNameError
from tendon_mj.typing import FloatArray


def arc_points(
    length: float,
    bend: float,
    guides: int,
    start: ArrayLike = (0.0, 0.0, 0.0),
    direction: ArrayLike = (1.0, 0.0, 0.0),
    normal: ArrayLike = (0.0, 0.0, 1.0),
) -> FloatArray:
    """Points of a sheath of uniform curvature: its two ends and the guides between.

    Each guide bends the path by ``bend``/n and the segments are ``length``/n long, the two end
    segments half of that, so length and total bend are exact for any number of guides.

    Args:
        length: of the sheath [m].
        bend: total angle that it turns through [rad]; positive turns left, seen from ``normal``.
        guides: n ≥ 1.
        start: of the path [m].
        direction: in which it leaves ``start``.
        normal: of the plane it bends in.

    Returns:
        (n+2, 3) points [m].

    Raises:
        InvalidValueError: length ≤ 0, no guide, or ``direction`` along ``normal``.
    """
    if not (np.isfinite(length) and length > 0.0):
        raise InvalidValueError(f"length = {length} [m] must be finite and > 0")
    if not np.isfinite(bend):
        raise InvalidValueError(f"bend = {bend} [rad] must be finite")
    if guides < 1 or guides != int(guides):
        raise InvalidValueError(f"guides = {guides} must be a whole number ≥ 1")
    if abs(bend) / guides > np.pi * (1.0 + 1e-12):
        raise InvalidValueError(
            f"guides = {guides} cannot bend by {bend:g} rad: each turns by π at most"
        )
    steps = np.full(guides + 1, length / guides)
    steps[[0, -1]] /= 2.0
    return _path(bend / guides * np.arange(guides + 1), steps, start, direction, normal)


def bent_points(
    length: float,
    bends: Sequence[tuple[float, float, float]],
    guides: int,
    start: ArrayLike = (0.0, 0.0, 0.0),
    direction: ArrayLike = (1.0, 0.0, 0.0),
    normal: ArrayLike = (0.0, 0.0, 1.0),
) -> FloatArray:
    """Points of a sheath that is bent in places and straight between them.

    Where the bends lie decides how much of the tendon moves after a reversal, and so how stiff it
    feels; the loss between its ends is that of an arc of the same total bend.

    Args:
        length: of the sheath [m].
        bends: (begin, end, angle) of each bend in order, along the sheath [m], [rad].
        guides: of all bends, shared out by their angles; each bend has one at least.
        start, direction, normal: as in ``arc_points``.

    Returns:
        (n+2, 3) points [m], n the number of guides of all bends.

    Raises:
        InvalidValueError: bends that overlap, lie outside the sheath or turn by nothing; too few
            guides.
    """
    total = sum(abs(angle) for _, _, angle in bends)
    where, turns, before = [0.0], [0.0], 0.0
    for begin, end, angle in bends:
        if not (before <= begin < end <= length and np.isfinite(angle) and angle != 0.0):
            raise InvalidValueError(
                f"bend ({begin:g} m, {end:g} m, {angle:g} rad) must lie behind the one before, "
                f"within the sheath's {length:g} m, and turn"
            )
        share = max(1, round(guides * abs(angle) / total))
        if abs(angle) / share > np.pi:
            raise InvalidValueError(f"guides = {guides} are too few: each turns by π at most")
        where += [begin + (k + 0.5) * (end - begin) / share for k in range(share)]
        turns += share * [angle / share]
        before = end
    steps = np.diff([*where, length])
    return _path(np.cumsum(turns), steps, start, direction, normal)


def _path(
    headings: ArrayLike, steps: ArrayLike, start: ArrayLike, direction: ArrayLike, normal: ArrayLike
) -> FloatArray:
    """Corners of a plane path with legs of these headings [rad] and lengths [m]."""
    along = np.asarray(direction, float)
    axis = np.asarray(normal, float)
    left = np.cross(axis, along)
    if not np.linalg.norm(left) > 0.0:
        raise InvalidValueError(f"direction {along} must not lie along normal {axis}")
    left /= np.linalg.norm(left)
    along = np.cross(left, axis)
    along /= np.linalg.norm(along)
    turns = np.outer(np.cos(headings), along) + np.outer(np.sin(headings), left)
    path: FloatArray = np.zeros((len(turns) + 1, 3))
    path[1:] = np.cumsum(np.reshape(steps, (-1, 1)) * turns, axis=0)
    path += np.asarray(start, float)
    return path


def add_sites(
    spec: mujoco.MjSpec, prefix: str, points: ArrayLike, body: str = "world"
) -> list[str]:
    """Add a site ``prefix_i`` for every point of a polyline, in the frame of ``body``.

    Args:
        spec: changed in place.
        prefix: of the sites' names.
        points: (k, 3) in the body's frame [m].
        body: that carries them.

    Returns:
        The sites' names in order.

    Raises:
        UnknownNameError: no such body.
        InvalidValueError: points are not (k, 3) and finite.
    """
    where = np.asarray(points, float)
    if where.ndim != 2 or where.shape[1] != 3 or not np.isfinite(where).all():
        raise InvalidValueError(f"points must be finite and of shape (k, 3), not {where.shape}")
    parent = spec.body(body)
    if parent is None:
        raise UnknownNameError("body", body, [b.name for b in spec.bodies])
    names = [f"{prefix}_{k}" for k in range(len(where))]
    for name, point in zip(names, where, strict=True):
        parent.add_site(name=name, pos=point)
    return names


def add_tendon(spec: mujoco.MjSpec, name: str, sites: Sequence[str]) -> mujoco.MjsTendon:
    """Add a spatial tendon through the named sites, input end first.

    Raises:
        UnknownNameError: a site that does not exist.
        InvalidValueError: fewer than two sites.
    """
    if len(sites) < 2:
        raise InvalidValueError(f"tendon {name!r} needs at least 2 sites, got {len(sites)}")
    known = [s.name for s in spec.sites]
    for site in sites:
        if site not in known:
            raise UnknownNameError("site", site, known, f"tendon {name!r}")
    tendon = spec.add_tendon(name=name)
    for site in sites:
        tendon.wrap_site(site)
    return tendon
