"""Forces of the tendon on sites and spools, in generalised coordinates.

A force f at p on body b adds, for each degree of freedom i that moves b, the power per unit speed
qfrc_i += cdof_i · (τ, f) with τ = (p − c) × f, where `mjData.cdof` is the spatial velocity of dof i
about c, the centre of mass of the kinematic tree.
"""

from __future__ import annotations

from tendon_mj.compilation import compiled
from tendon_mj.engine.abi.layout import Layout
from tendon_mj.engine.abi.memory import coordinates, doubles, integer, pointer
from tendon_mj.engine.sheath_plugin.state import State
from tendon_mj.engine.sheath_plugin.strain_law import spool_torque
from tendon_mj.sheath.records import Array, Segments


@compiled
def _add_force(
    layout: Layout, m: int, d: int, body: int, p: Array, at: int, fx: float, fy: float, fz: float
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


@compiled
def _add_torque(layout: Layout, m: int, d: int, joint: float, torque: float) -> None:
    """Add the torque that the tendon exerts on a spool's joint; nothing without a joint."""
    if joint >= 0.0:
        dof = integer(pointer(m + layout.m_jnt_dofadr), int(joint))
        doubles(pointer(d + layout.d_qfrc_passive) + 8 * dof, 1)[0] += torque


@compiled
def apply_forces(
    layout: Layout, m: int, d: int, state: State, segments: Segments, p: Array
) -> None:
    """Apply the tendon's forces to the bodies along the path and to the spools."""
    ea, last = state.law.axial_stiffness, len(segments) - 1
    first = integer(pointer(m + layout.m_tendon_adr), int(state.tendon))
    sites = pointer(m + layout.m_wrap_objid)
    bodies = pointer(m + layout.m_site_bodyid)
    # a segment pulls its two ends together; on one body that does nothing
    body = integer(bodies, integer(sites, first))
    for j in range(last + 1):
        other = integer(bodies, integer(sites, first + j + 1))
        if body != other and segments[j].tension > 0.0:
            pull = ea * segments[j].tension / segments[j].length
            fx = pull * (p[3 * j + 3] - p[3 * j])
            fy = pull * (p[3 * j + 4] - p[3 * j + 1])
            fz = pull * (p[3 * j + 5] - p[3 * j + 2])
            _add_force(layout, m, d, body, p, 3 * j, fx, fy, fz)
            _add_force(layout, m, d, other, p, 3 * j + 3, -fx, -fy, -fz)
        body = other
    _add_torque(layout, m, d, state.reel_joint, -state.reel_torque)
    torque = spool_torque(state, segments, last, state.output_radius)
    _add_torque(layout, m, d, state.output_joint, -torque)
