"""Forces on sites, carried into generalised coordinates.

A force f at p on body b adds, for each degree of freedom i that moves b, the power per unit speed
qfrc_i += cdof_i · (τ, f) with τ = (p − c) × f, where `mjData.cdof` is the spatial velocity of dof i
about c, the centre of mass of the kinematic tree.
"""

from __future__ import annotations

from typing import Any

from tendon_mj.compilation import compiled
from tendon_mj.engine.abi.memory import coordinates, integer, pointer


@compiled
def add_force(
    layout: Any, m: int, d: int, body: int, p: Any, at: int, fx: float, fy: float, fz: float
) -> None:
    """Add force (fx, fy, fz) [N] at ``p[at:at+3]`` [m] of ``body`` to `mjData.qfrc_passive`."""
    if integer(pointer(m + layout.m_body_weldid), body) == 0:
        return  # fixed to the world
    root = integer(pointer(m + layout.m_body_rootid), body)
    centre = coordinates(pointer(d + layout.d_subtree_com) + 24 * root)
    rx, ry, rz = p[at] - centre[0], p[at + 1] - centre[1], p[at + 2] - centre[2]
    tx, ty, tz = ry * fz - rz * fy, rz * fx - rx * fz, rx * fy - ry * fx
    while integer(pointer(m + layout.m_body_dofnum), body) == 0:
        body = integer(pointer(m + layout.m_body_parentid), body)
        if body == 0:
            return
    dof = integer(pointer(m + layout.m_body_dofadr), body)
    dof += integer(pointer(m + layout.m_body_dofnum), body) - 1
    parents = pointer(m + layout.m_dof_parentid)
    motion, passive = pointer(d + layout.d_cdof), coordinates(pointer(d + layout.d_qfrc_passive))
    while dof >= 0:
        c = coordinates(motion + 48 * dof)
        force = c[0] * tx + c[1] * ty + c[2] * tz + c[3] * fx + c[4] * fy + c[5] * fz
        passive[dof] += force
        dof = integer(parents, dof)
