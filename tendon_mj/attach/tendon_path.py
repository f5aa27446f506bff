"""Path of a spatial tendon as a spec describes it: its branches, what they run over, its guides."""

from __future__ import annotations

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
