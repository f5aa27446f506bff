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
    bodies = [_moving(point.target.parent) for point in points]
    beyond = bodies[1:] if input_end == "first" else bodies[:-1]
    return len(set(beyond)) == 1


def _moving(body: mujoco.MjsBody) -> mujoco.MjsBody:
    """The nearest body with a joint, from this one up; the world where there is none."""
    while body.parent is not None and not list(body.joints):
        body = body.parent
    return body


def limited_joints(spec: mujoco.MjSpec, tendons: Sequence[str]) -> dict[str, list[str]]:
    """Tendon → the joints that it crosses and that limit the force of their actuators."""
    limited = {joint.name for joint in spec.joints if _is_limited(joint)}
    if not limited:
        return {}
    model = spec.compile()
    found = {name: [j for j in _joints_crossed(model, name) if j in limited] for name in tendons}
    return {name: joints for name, joints in found.items() if joints}


def _is_limited(joint: mujoco.MjsJoint) -> bool:
    limited, (low, high) = int(joint.actfrclimited), joint.actfrcrange
    if limited == mujoco.mjtLimited.mjLIMITED_AUTO:
        return bool(low < high)
    return limited == int(mujoco.mjtLimited.mjLIMITED_TRUE)


def _joints_crossed(model: mujoco.MjModel, tendon: str) -> list[str]:
    """Joints between the bodies that a spatial tendon runs over."""
    index = model.tendon(tendon).id
    first, bodies = int(model.tendon_adr[index]), set[int]()
    for element in range(first, first + int(model.tendon_num[index])):
        kind, target = model.wrap_type[element], model.wrap_objid[element]
        if kind != _WRAP.mjWRAP_PULLEY:
            owners = model.site_bodyid if kind == _WRAP.mjWRAP_SITE else model.geom_bodyid
            bodies.add(int(owners[target]))
    above = [_above(model, body) for body in bodies]
    crossed = above[0].union(*above) - above[0].intersection(*above)
    return [model.joint(k).name for k in range(model.njnt) if model.jnt_bodyid[k] in crossed]


def _above(model: mujoco.MjModel, body: int) -> set[int]:
    """A body and all that carry it."""
    chain = {0}
    while body > 0:
        chain.add(body)
        body = int(model.body_parentid[body])
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
