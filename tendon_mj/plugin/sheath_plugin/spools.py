"""Tendon that the spools have wound, and the torque that the reel's drive bears.

With backlash b the drum follows its drive once that has crossed the gap, and holds itself in it.
Where the drive is a joint, the flank by which it winds is a spring, as stiff as the joint's inertia
allows at this time step: the drive bears the contact force, and the drum yields where that is more
than the tendon's pull. No tendon is wound without work of the drive.

Equations: docs/theory.md, section 7.
"""

from __future__ import annotations

from tendon_mj.compilation import compiled
from tendon_mj.plugin.abi.layout import Layout
from tendon_mj.plugin.abi.memory import double, integer, pointer
from tendon_mj.plugin.sheath_plugin.state import State
from tendon_mj.plugin.sheath_plugin.strain_law import spool_torque
from tendon_mj.sheath import Segments, convected

_RIGIDITY = 0.25  # of the flank: (ωh)² of the drive on it; explicit steps are stable below 4


@compiled
def wound_by(layout: Layout, m: int, d: int, joint: float, radius: float) -> float:
    """Tendon that a spool on a joint has wound in since `qpos0` [m]; 0 without a joint."""
    if joint < 0.0:
        return 0.0
    adr = integer(pointer(m + layout.m_jnt_qposadr), int(joint))
    angle = double(pointer(d + layout.d_qpos), adr) - double(pointer(m + layout.m_qpos0), adr)
    return radius * angle


@compiled
def flank_stiffness(layout: Layout, m: int, state: State, elapsed: float) -> float:
    """Stiffness of the contact between drive and drum [N/m]; inf without a joint to stop."""
    if state.law.backlash == 0.0 or state.reel_joint < 0.0:
        return float("inf")
    dof = integer(pointer(m + layout.m_jnt_dofadr), int(state.reel_joint))
    mobility = double(pointer(m + layout.m_dof_invweight0), dof) * state.reel_radius**2
    return _RIGIDITY / (mobility * elapsed * elapsed)


@compiled
def on_drum(state: State, segments: Segments, drive: float, flank: float) -> float:
    """Tendon on the drum when its drive stands at ``drive`` [m]."""
    if state.law.backlash == 0.0:
        return drive
    half = 0.5 * state.law.backlash
    before = max(0.0, segments[0].previous_tension)
    pull = state.law.axial_stiffness * convected(before, state.law.stiffening)
    return min(max(state.wound_in, drive - half - pull / flank), drive + half)


@compiled
def torque_on_drive(state: State, segments: Segments, ahead: float, flank: float) -> float:
    """Torque by which the tendon turns the reel's joint back [N m].

    Args:
        state, segments: of the sheath.
        ahead: length by which the drive is ahead of the drum [m].
        flank: stiffness of their contact [N/m].
    """
    if state.reel_joint < 0.0:
        return 0.0
    torque = spool_torque(state, segments, 0, state.reel_radius)
    if state.law.backlash == 0.0:
        return torque
    pressed = state.reel_radius * flank * max(0.0, ahead - 0.5 * state.law.backlash)
    return min(abs(torque), abs(pressed)) * (1.0 if torque > 0.0 else -1.0)
