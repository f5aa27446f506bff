"""The force by which MuJoCo pulls along a tendon: its actuators, its spring and its damper.

    f = Σ g f_a − x k(x) − v c(v)

with g f_a the gear times the force of each actuator on the tendon, x how much the tendon is longer
or shorter than its spring's range, v = dL/dt, and k and c MuJoCo's polynomials. It pulls where it
is negative. MuJoCo computes actuators after passive forces, so the first sheath that is driven has
them computed; what comes out is the same when MuJoCo computes them again.
"""

from __future__ import annotations

import mujoco

from tendon_mj.abi.layout import Layout
from tendon_mj.abi.library import mj_actuatorDamping, mj_fwdActuation, mju_polyForce
from tendon_mj.abi.memory import double, doubles, integer, pointer
from tendon_mj.compilation import compiled
from tendon_mj.engine.sheath_plugin.state import DAMPING_POLY, State

ON_TENDON = mujoco.mjtTrn.mjTRN_TENDON.value
_TENDON = mujoco.mjtObj.mjOBJ_TENDON.value
_SPRING_OFF = mujoco.mjtDisableBit.mjDSBL_SPRING.value
_DAMPER_OFF = mujoco.mjtDisableBit.mjDSBL_DAMPER.value
_POLY = 2  # mjNPOLY


@compiled
def acts_on(layout: Layout, m: int, actuator: int, tendon: int) -> bool:
    """Whether an actuator's transmission is a tendon."""
    kind = integer(pointer(m + layout.m_actuator_trntype), actuator)
    return kind == ON_TENDON and (
        integer(pointer(m + layout.m_actuator_trnid), 2 * actuator) == tendon
    )


@compiled
def has_spring(layout: Layout, m: int, tendon: int) -> bool:
    """Whether a tendon has a stiffness of its own."""
    higher = doubles(pointer(m + layout.m_tendon_stiffnesspoly) + 16 * tendon, _POLY)
    linear = double(pointer(m + layout.m_tendon_stiffness), tendon)
    return linear != 0.0 or higher[0] != 0.0 or higher[1] != 0.0


@compiled
def _spring(layout: Layout, m: int, d: int, tendon: int) -> float:
    if not has_spring(layout, m, tendon):
        return 0.0
    length = double(pointer(d + layout.d_ten_length), tendon)
    low = double(pointer(m + layout.m_tendon_lengthspring), 2 * tendon)
    high = double(pointer(m + layout.m_tendon_lengthspring), 2 * tendon + 1)
    x = length - high if length > high else (length - low if length < low else 0.0)
    linear = double(pointer(m + layout.m_tendon_stiffness), tendon)
    poly = pointer(m + layout.m_tendon_stiffnesspoly) + 16 * tendon
    return -x * mju_polyForce(linear, poly, x, _POLY, 0)


@compiled
def _damper(layout: Layout, m: int, d: int, address: int, tendon: int) -> float:
    work = address + DAMPING_POLY
    poly = doubles(work, _POLY)
    own = doubles(pointer(m + layout.m_tendon_dampingpoly) + 16 * tendon, _POLY)
    poly[0], poly[1] = own[0], own[1]
    linear = double(pointer(m + layout.m_tendon_damping), tendon)
    if integer(pointer(m + layout.m_tendon_actuatorid), tendon) != -1:
        linear += mj_actuatorDamping(m, _TENDON, tendon, work)
    if linear == 0.0 and poly[0] == 0.0 and poly[1] == 0.0:
        return 0.0
    v = double(pointer(d + layout.d_ten_velocity), tendon)
    return -v * mju_polyForce(linear, work, v, _POLY, 1)


@compiled
def input_force(layout: Layout, m: int, d: int, address: int, state: State) -> float:
    """Force along the tendon [N], pulling where it is negative."""
    tendon, force = int(state.tendon), 0.0
    if state.leads != 0.0:
        mj_fwdActuation(m, d)
    if state.first_actuator >= 0.0:
        for actuator in range(int(state.first_actuator), int(state.last_actuator) + 1):
            if acts_on(layout, m, actuator, tendon):
                adr = integer(pointer(m + layout.m_actuator_outadr), actuator)
                gear = double(pointer(m + layout.m_actuator_gear), 6 * adr)
                force += gear * double(pointer(d + layout.d_actuator_force), adr)
    off = integer(m + layout.o_disableflags, 0)
    if not off & _SPRING_OFF:
        force += _spring(layout, m, d, tendon)
    if not off & _DAMPER_OFF:
        force += _damper(layout, m, d, address, tendon)
    return force


@compiled
def input_strain(state: State) -> float:
    """τ that the force of this evaluation gives the first segment; 0 where it pushes."""
    return max(0.0, -state.input_force) / state.law.axial_stiffness
