"""Path of a spatial tendon as a spec describes it: its branches, what they run over, its guides."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import mujoco

_WRAP = mujoco.mjtWrap


class Branch(NamedTuple):
    """Stretch of a tendon between pulleys."""

    sites: int
    wraps: int  # geoms that it may wrap around


class TendonPath(NamedTuple):
    """Path of a tendon: all that it runs over.

    Attributes:
        branches: one, and one more for each pulley.
        joints: of a fixed tendon; 0 for a spatial one.
    """

    branches: tuple[Branch, ...]
    joints: int

    @property
    def is_spatial(self) -> bool:
        """Whether it runs through space, not over joints."""
        return self.joints == 0

    @property
    def wraps(self) -> int:
        """Number of geoms that it may wrap around."""
        return sum(branch.wraps for branch in self.branches)

    def bends(self, arc_guides: int = 1) -> int:
        """Guides that can bend: the inner sites of each branch, `arc_guides` a geom."""
        within = sum(max(branch.sites - 2, 0) for branch in self.branches)
        return within + self.wraps * arc_guides

    @property
    def is_bent_at_sites(self) -> bool:
        """Whether it has a guide at a site, which is there whatever the pose."""
        return self.bends(0) > 0

    def guides(self, arc_guides: int = 1) -> int:
        """Number of guides of the path: those that can bend, and one a pulley."""
        return self.bends(arc_guides) + len(self.branches) - 1


def end_sites(tendon: mujoco.MjsTendon) -> list[tuple[str, str]]:
    """Names of the first and the last site of each branch of a spatial tendon."""
    branches: list[list[str]] = [[]]
    for point in tendon.path:
        if point.type == _WRAP.mjWRAP_PULLEY:
            branches.append([])
        elif point.type == _WRAP.mjWRAP_SITE:
            branches[-1].append(point.target.name if point.target is not None else "")
    return [(sites[0], sites[-1]) if sites else ("", "") for sites in branches]


def guides_are_beyond(tendon: mujoco.MjsTendon, input_end: str) -> bool:
    """Whether all guides of an unbranched tendon are on the body at which it ends.

    Friction at a guide takes tension from what comes behind it, and that pulls on one body alone.
    """
    points = list(tendon.path)
    if any(p.type == _WRAP.mjWRAP_PULLEY or p.target is None for p in points):
        return False
    return not _joints_between(points[1:] if input_end == "first" else points[:-1])


def crossed_joints(tendon: mujoco.MjsTendon) -> list[mujoco.MjsJoint]:
    """Joints that a spatial tendon crosses."""
    points = [p for p in tendon.path if p.type != _WRAP.mjWRAP_PULLEY and p.target is not None]
    return _joints_between(points)


def is_limited(limited: int, ends: Sequence[float]) -> bool:
    """Whether a range of a spec limits, which by default it does where it is one."""
    if int(limited) == mujoco.mjtLimited.mjLIMITED_AUTO:
        return bool(ends[0] < ends[1])
    return int(limited) == int(mujoco.mjtLimited.mjLIMITED_TRUE)


def idlers_are_possible(tendon: mujoco.MjsTendon) -> bool:
    """Whether a tendon may wrap around a geom on a body that carries none of its sites."""
    targets = [point.target for point in tendon.path if point.type != _WRAP.mjWRAP_PULLEY]
    sites = [target for target in targets if isinstance(target, mujoco.MjsSite)]
    carriers = {body for site in sites for body in _above(site.parent)}
    return any(
        body.joints and body not in carriers
        for geom in targets
        if isinstance(geom, mujoco.MjsGeom)
        for body in _above(geom.parent)
    )


def _joints_between(points: Sequence[mujoco.MjsWrap]) -> list[mujoco.MjsJoint]:
    """Joints between the bodies of points on a path."""
    chains = [_above(point.target.parent) for point in points]
    bodies = dict.fromkeys(body for chain in chains for body in chain)
    return [
        joint
        for body in bodies
        if not all(body in chain for chain in chains)
        for joint in body.joints
    ]


def _above(body: mujoco.MjsBody) -> list[mujoco.MjsBody]:
    """A body and all that carry it."""
    chain = [body]
    while chain[-1].parent is not None:
        chain.append(chain[-1].parent)
    return chain


def path_of(tendon: mujoco.MjsTendon) -> TendonPath:
    """Path of a tendon."""
    branches, joints = [Branch(0, 0)], 0
    for point in tendon.path:
        sites, wraps = branches[-1]
        if point.type == _WRAP.mjWRAP_JOINT:
            joints += 1
        elif point.type == _WRAP.mjWRAP_PULLEY:
            branches.append(Branch(0, 0))
        elif point.type == _WRAP.mjWRAP_SITE:
            branches[-1] = Branch(sites + 1, wraps)
        else:  # a sphere or a cylinder; which of the two is known once it is compiled
            branches[-1] = Branch(sites, wraps + 1)
    return TendonPath(tuple(branches), joints)
