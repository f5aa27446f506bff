"""How much tendon the spools have wound, and what the reel's drive feels of it.

With backlash b the drum follows its drive once that has crossed the gap, and holds itself in it.
Where the drive is a joint, the flank by which it winds is a spring, as stiff as the joint's inertia
allows at this time step: the drive bears what presses on it, and the drum gives way where that is
more than the tendon's pull. So nothing is wound that the drive has not paid for.

Equations: docs/theory.md, section 7.
"""

from __future__ import annotations

from typing import Any

from tendon_mj.compilation import compiled
from tendon_mj.engine.abi.memory import double, integer, pointer
from tendon_mj.engine.sheath_plugin import state as st
from tendon_mj.engine.sheath_plugin.strain import spool_torque
from tendon_mj.sheath.segments import borne

_RIGIDITY = 0.25  # of the flank: (ωh)² of the drive on it; explicit steps are stable below 4


@compiled
def turned(layout: Any, m: int, d: int, state: Any, joint: int, radius: int) -> float:
    """Tendon that the spool on a joint has wound in since `qpos0` [m]; 0 without a spool."""
    if state[joint] < 0.0:
        return 0.0
    adr = integer(pointer(m + layout.m_jnt_qposadr), int(state[joint]))
    turn = double(pointer(d + layout.d_qpos), adr) - double(pointer(m + layout.m_qpos0), adr)
    return state[radius] * turn


@compiled
def flank_stiffness(layout: Any, m: int, state: Any, elapsed: float) -> float:
    """Of the contact between drive and drum [N/m]; inf where no joint could be stopped by it."""
    if state[st.BACKLASH] == 0.0 or state[st.REEL_JOINT] < 0.0:
        return float("inf")
    dof = integer(pointer(m + layout.m_jnt_dofadr), int(state[st.REEL_JOINT]))
    mobility = double(pointer(m + layout.m_dof_invweight0), dof) * state[st.REEL_RADIUS] ** 2
    return _RIGIDITY / (mobility * elapsed * elapsed)


@compiled
def on_drum(state: Any, segments: Any, drive: float, flank: float) -> float:
    """Tendon on the drum when its drive stands at ``drive`` [m]."""
    if state[st.BACKLASH] == 0.0:
        return drive
    half = 0.5 * state[st.BACKLASH]
    pull = state[st.AXIAL_STIFFNESS] * borne(max(0.0, segments[st.START, 0]), state[st.STIFFENING])
    return min(max(state[st.WOUND_IN], drive - half - pull / flank), drive + half)


@compiled
def torque_on_drive(state: Any, segments: Any, ahead: float, flank: float) -> float:
    """Torque by which the tendon turns the reel's joint back [N m].

    Args:
        ahead: of the drum, by which the drive stands [m].
    """
    if state[st.REEL_JOINT] < 0.0:
        return 0.0
    torque = spool_torque(state, segments, 0, state[st.REEL_RADIUS])
    if state[st.BACKLASH] == 0.0:
        return torque
    pressed = state[st.REEL_RADIUS] * flank * max(0.0, ahead - 0.5 * state[st.BACKLASH])
    return min(abs(torque), abs(pressed)) * (1.0 if torque > 0.0 else -1.0)
