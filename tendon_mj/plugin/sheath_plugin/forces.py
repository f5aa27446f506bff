"""Forces of the tendon on bodies and spools, in generalised coordinates.

A straight span of length ℓ under tension T pulls its two ends together, which is −T J with
J = ∂ℓ/∂q. With u its direction and `mjData.cdof` the spatial velocity (ω, v) of dof i about c, the
centre of mass of the kinematic tree,

    J_i = ±(v · u + ω · ((p − c) × u))

+ where the dof moves the far end p, − where it moves the near one. A dof that moves both does not
change the length.

MuJoCo's actuators, springs and constraints act with one tension along the whole tendon. A sheath
that they drive adds the difference that friction makes, T − T_in for each span, and nothing where
nothing rubs. One whose elasticity is the tendon's own spring adds T − k (L − S).
"""

from __future__ import annotations

import math

from tendon_mj.compilation import compiled
from tendon_mj.plugin.abi.layout import Layout
from tendon_mj.plugin.abi.memory import coordinates, doubles, integer, pointer
from tendon_mj.plugin.sheath_plugin.input_force import counted_strain
from tendon_mj.plugin.sheath_plugin.state import State
from tendon_mj.plugin.sheath_plugin.strain_law import spool_torque
from tendon_mj.sheath import Segment, Segments
from tendon_mj.typing import FloatArray


@compiled
def _last_dof(layout: Layout, m: int, body: int) -> int:
    """The last degree of freedom that moves a body, −1 without one."""
    body = integer(pointer(m + layout.m_body_weldid), body)
    while body > 0 and integer(pointer(m + layout.m_body_dofnum), body) == 0:
        body = integer(pointer(m + layout.m_body_parentid), body)
    if body == 0:
        return -1
    count = integer(pointer(m + layout.m_body_dofnum), body)
    return integer(pointer(m + layout.m_body_dofadr), body) + count - 1


@compiled
def _pull(
    layout: Layout,
    m: int,
    d: int,
    p: FloatArray,
    at: int,
    segment: Segment,
    tension: float,
    force: FloatArray,
) -> None:
    """Add −T J of the span from point ``at`` to the next to ``force``."""
    near = _last_dof(layout, m, int(segment.near_body))
    far = _last_dof(layout, m, int(segment.far_body))
    k = 3 * at
    ux, uy, uz = p[k + 3] - p[k], p[k + 4] - p[k + 1], p[k + 5] - p[k + 2]
    length = math.sqrt(ux * ux + uy * uy + uz * uz)
    if length == 0.0:
        return
    ux, uy, uz = ux / length, uy / length, uz / length
    roots, parents = pointer(m + layout.m_body_rootid), pointer(m + layout.m_dof_parentid)
    centres, motions = pointer(d + layout.d_subtree_com), pointer(d + layout.d_cdof)
    for end in range(2):
        # the dofs of one end that are not the other's too: from the leaf to the common ancestor
        dof, other = (near, far) if end == 0 else (far, near)
        if dof < 0:
            continue
        body = int(segment.near_body) if end == 0 else int(segment.far_body)
        sign, at_end = (-1.0, k) if end == 0 else (1.0, k + 3)
        c = coordinates(centres + 24 * integer(roots, body))
        rx, ry, rz = p[at_end] - c[0], p[at_end + 1] - c[1], p[at_end + 2] - c[2]
        tx, ty, tz = ry * uz - rz * uy, rz * ux - rx * uz, rx * uy - ry * ux
        while dof != other and dof >= 0:
            if other > dof:
                other = integer(parents, other)
                continue
            s = coordinates(motions + 48 * dof)
            value = s[0] * tx + s[1] * ty + s[2] * tz + s[3] * ux + s[4] * uy + s[5] * uz
            force[dof] -= sign * value * tension
            dof = integer(parents, dof)


@compiled
def pull_segment(
    layout: Layout,
    m: int,
    d: int,
    state: State,
    segment: Segment,
    tension: float,
    force: FloatArray,
) -> None:
    """Add the generalised force of a segment's span under a tension [N].

    Args:
        layout, m, d: where things are, `mjModel`, `mjData`.
        state, segment: of the sheath.
        tension: −1 adds J itself.
        force: of every dof, added to; nothing for a segment that connects no two bodies.
    """
    if segment.point >= 0.0 and segment.near_body != segment.far_body:
        points = coordinates(pointer(d + layout.d_wrap_xpos))
        at = integer(pointer(d + layout.d_ten_wrapadr), int(state.tendon)) + int(segment.point)
        _pull(layout, m, d, points, at, segment, tension, force)


@compiled
def _add_torque(layout: Layout, m: int, d: int, joint: float, torque: float) -> None:
    """Add the torque that the tendon exerts on a spool's joint; nothing without a joint."""
    if joint >= 0.0:
        dof = integer(pointer(m + layout.m_jnt_dofadr), int(joint))
        doubles(pointer(d + layout.d_qfrc_passive) + 8 * dof, 1)[0] += torque


@compiled
def apply_forces(layout: Layout, m: int, d: int, state: State, segments: Segments) -> None:
    """Apply the tendon's forces to the bodies along the path and to the spools."""
    ea, last = state.law.axial_stiffness, len(segments) - 1
    given = counted_strain(state)
    state.applied = 1.0
    passive = coordinates(pointer(d + layout.d_qfrc_passive))
    for j in range(last + 1):
        segment = segments[j]
        tension = ea * (segment.tension - given / segment.divisor)
        if tension != 0.0:
            pull_segment(layout, m, d, state, segment, tension, passive)
    if state.driven != 0.0:
        return
    _add_torque(layout, m, d, state.reel_joint, -state.reel_torque)
    torque = spool_torque(state, segments, last, state.output_radius)
    _add_torque(layout, m, d, state.output_joint, -torque)
