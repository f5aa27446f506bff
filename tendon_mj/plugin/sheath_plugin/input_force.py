"""The force with which MuJoCo acts along a tendon: actuators, spring, damper and constraints.

    f = Σ g f_a − x k(x) − v c(v) + λ

with g f_a the gear times the force of each actuator on the tendon, x how much the tendon is longer
or shorter than its spring's range, v = dL/dt, k and c MuJoCo's polynomials, and λ the force of
equalities and of the tendon's limit. It pulls where it is negative.

MuJoCo computes actuators after passive forces, and driven tendons are solved once it has: a
control that is set between `mj_step1` and `mj_step2`, or by `mjcb_control`, meets friction in the
same step, and so do those that `mjd_transitionFD` varies. Constraints are solved last: λ is that
of the step before. On an elastic tendon it follows by a fifth of the difference in each step, so
that a constraint and the friction that answers it settle instead of alternating.

A tendon whose own spring is the cable's elasticity is not driven. Its stiffness k and rest length S
make EA = k S, and S is its unstretched length: a shorter S is tendon wound in at the input. MuJoCo
still pulls with k (L − S) along the whole tendon, which the sheath takes back.
"""

from __future__ import annotations

import mujoco

from tendon_mj.native import apart, compiled
from tendon_mj.plugin.abi.layout import Data, Model
from tendon_mj.plugin.abi.library import mj_actuatorDamping, mju_polyForce
from tendon_mj.plugin.abi.memory import doubles
from tendon_mj.plugin.sheath_plugin.fixed_tendon import coefficient_of, metres
from tendon_mj.plugin.sheath_plugin.response import damping_of
from tendon_mj.plugin.sheath_plugin.state import DAMPING_POLY, State

ON_TENDON = mujoco.mjtTrn.mjTRN_TENDON.value
_ON_JOINT = mujoco.mjtTrn.mjTRN_JOINT.value
_ON_JOINT_IN_PARENT = mujoco.mjtTrn.mjTRN_JOINTINPARENT.value
_TENDON = mujoco.mjtObj.mjOBJ_TENDON.value
_ACTUATION_OFF = mujoco.mjtDisableBit.mjDSBL_ACTUATION.value
_SPRING_OFF = mujoco.mjtDisableBit.mjDSBL_SPRING.value
_DAMPER_OFF = mujoco.mjtDisableBit.mjDSBL_DAMPER.value
_POLY = 2  # mjNPOLY
_TENDON_LOSS = mujoco.mjtConstraint.mjCNSTR_FRICTION_TENDON.value
_TENDON_LIMIT = mujoco.mjtConstraint.mjCNSTR_LIMIT_TENDON.value
_OF_TENDONS = mujoco.mjtEq.mjEQ_TENDON.value
_NO_BIAS = mujoco.mjtBias.mjBIAS_NONE.value
_FOLLOWS = 0.2  # share of a constraint's change that counts in the next step of an elastic tendon
_SAME = 1e-9  # relative; a tendon that is longer than its path by less is not slack


@compiled
def pulls(m: Model, actuator: int, tendon: int) -> bool:
    """Return whether an actuator's transmission is a tendon."""
    return m.actuator_trntype[actuator] == ON_TENDON and m.actuator_trnid[actuator, 0] == tendon


@compiled
def acts_on(m: Model, actuator: int, tendon: int) -> bool:
    """Return whether an actuator acts on a tendon, or on the joint that a cable not drawn turns."""
    kind, target = m.actuator_trntype[actuator], m.actuator_trnid[actuator, 0]
    if kind in (_ON_JOINT, _ON_JOINT_IN_PARENT):
        return coefficient_of(m, tendon, target) != 0.0
    return pulls(m, actuator, tendon)


@compiled
def _force_per_force(m: Model, actuator: int, tendon: int) -> float:
    """Force along a tendon per force of an actuator that acts on it."""
    gear = m.actuator_gear[m.actuator_outadr[actuator], 0]
    if m.actuator_trntype[actuator] == ON_TENDON:
        return gear
    return gear / coefficient_of(m, tendon, m.actuator_trnid[actuator, 0])


@compiled
def has_spring(m: Model, tendon: int) -> bool:
    """Return whether a tendon has a stiffness of its own."""
    higher = m.tendon_stiffnesspoly[tendon]
    linear = m.tendon_stiffness[tendon]
    return linear != 0.0 or higher[0] != 0.0 or higher[1] != 0.0


@compiled
def is_constrained(m: Model, tendon: int) -> bool:
    """Return whether an equality or a limit may act on a tendon."""
    if m.tendon_limited[tendon]:
        return True
    for k in range(m.neq):
        if m.eq_type[k] == _OF_TENDONS and tendon in (m.eq_obj1id[k], m.eq_obj2id[k]):
            return True
    return False


@compiled
def _spring(m: Model, d: Data, tendon: int) -> float:
    if not has_spring(m, tendon):
        return 0.0
    length = d.ten_length[tendon]
    low, high = m.tendon_lengthspring[tendon, 0], m.tendon_lengthspring[tendon, 1]
    x = length - high if length > high else (length - low if length < low else 0.0)
    linear = m.tendon_stiffness[tendon]
    poly = m.tendon_stiffnesspoly[tendon]
    return -x * mju_polyForce(linear, poly, x, _POLY, 0)


@compiled
def _damper(m: Model, d: Data, address: int, tendon: int) -> float:
    work = address + DAMPING_POLY
    poly = doubles(work, _POLY)
    own = m.tendon_dampingpoly[tendon]
    poly[0], poly[1] = own[0], own[1]
    linear = m.tendon_damping[tendon]
    if m.tendon_actuatorid[tendon] != -1:
        linear += mj_actuatorDamping(m, _TENDON, tendon, work)
    if linear == 0.0 and poly[0] == 0.0 and poly[1] == 0.0:
        return 0.0
    v = d.ten_velocity[tendon]
    return -v * mju_polyForce(linear, work, v, _POLY, 1)


@apart
def tendon_damping(m: Model, state: State) -> float:
    """Linear damping of a tendon itself [N s/m]."""
    if m.opt.disableflags & _DAMPER_OFF:
        return 0.0
    return m.tendon_damping[int(state.tendon)] / metres(state) ** 2


@apart
def actuator_damping(m: Model, d: Data, state: State) -> float:
    """Force along a tendon per velocity of it that its actuators add implicitly [N s/m]."""
    damping = 0.0
    if state.first_actuator >= 0.0:
        for actuator in range(int(state.first_actuator), int(state.last_actuator) + 1):
            if acts_on(m, actuator, int(state.tendon)):
                gear = _force_per_force(m, actuator, int(state.tendon)) / metres(state)
                damping += gear * gear * damping_of(m, d, actuator)
    return damping


@compiled
def _of_actuators(m: Model, d: Data, state: State, motors: bool) -> float:
    """The force of actuators along a tendon [N], or of its ``motors`` alone, which have no bias."""
    force = 0.0
    if state.first_actuator >= 0.0:
        for actuator in range(int(state.first_actuator), int(state.last_actuator) + 1):
            counts = not motors or m.actuator_biastype[actuator] == _NO_BIAS
            if counts and acts_on(m, actuator, int(state.tendon)):
                adr = m.actuator_outadr[actuator]
                gear = _force_per_force(m, actuator, int(state.tendon))
                force += gear * d.actuator_force[adr]
    return force


@compiled
def _unconstrained(m: Model, d: Data, address: int, state: State) -> float:
    """The force of actuators, spring and damper [N]."""
    tendon, force = int(state.tendon), 0.0
    off = m.opt.disableflags
    if not off & _ACTUATION_OFF:
        force = _of_actuators(m, d, state, False)
    if not off & _SPRING_OFF:
        force += _spring(m, d, tendon)
    if not off & _DAMPER_OFF:
        force += _damper(m, d, address, tendon)
    return force


@apart
def is_pushed(m: Model, d: Data, state: State) -> bool:
    """Return whether motors push a tendon: actuators whose force is their control alone.

    A servo pushes in passing, where its command is behind the tendon.
    """
    pushes = state.input_force > 0.0 and state.fixed == 0.0
    return pushes and _of_actuators(m, d, state, True) > 0.0


@compiled
def input_force(m: Model, d: Data, address: int, state: State) -> float:
    """Force along the tendon [N], pulling where it is negative."""
    force = _unconstrained(m, d, address, state) / metres(state)
    if state.constrained != 0.0:
        force += state.constraint_force
    return force


@compiled
def holds_length(m: Model, tendon: int) -> bool:
    """Return whether a limit, or an equality with no other tendon, holds a tendon's length."""
    if m.tendon_limited[tendon]:
        return True
    for k in range(m.neq):
        is_of_tendons = m.eq_type[k] == _OF_TENDONS
        if is_of_tendons and m.eq_obj1id[k] == tendon and m.eq_obj2id[k] < 0:
            return True
    return False


@apart
def _constraint_force(m: Model, d: Data, tendon: int) -> float:
    """λ of the constraints that MuJoCo has solved [N], pulling where negative."""
    force, equalities = 0.0, d.ne
    for row in range(equalities):
        which = d.efc_id[row]
        value = d.efc_force[row]
        if m.eq_type[which] == _OF_TENDONS:
            second = m.eq_obj2id[which]
            if m.eq_obj1id[which] == tendon:
                force += value
            if second == tendon:
                x = d.ten_length[second] - m.tendon_length0[second]
                c = m.eq_data[which]
                force -= value * (c[1] + x * (2.0 * c[2] + x * (3.0 * c[3] + x * 4.0 * c[4])))
    begin, end = equalities + d.nf, d.nefc
    for row in range(begin, end):
        kind = d.efc_type[row]
        if kind > _TENDON_LIMIT:  # contacts come last
            break
        if kind == _TENDON_LIMIT and d.efc_id[row] == tendon:
            length = d.ten_length[tendon]
            ends = m.tendon_range[tendon]
            value = d.efc_force[row]
            force += value if length - ends[0] < ends[1] - length else -value
    return force


@apart
def uniform_force(m: Model, d: Data, address: int, state: State) -> float:
    """Force along the tendon with the constraints just solved and its `frictionloss` [N]."""
    tendon = int(state.tendon)
    force = _unconstrained(m, d, address, state) + _constraint_force(m, d, tendon)
    begin = d.ne
    for row in range(begin, begin + d.nf):
        if d.efc_type[row] == _TENDON_LOSS and d.efc_id[row] == tendon:
            force += d.efc_force[row]
    return force


@compiled
def follow_constraint(m: Model, d: Data, state: State) -> None:
    """Let the force of this step's constraints count from the next step on."""
    if state.constrained != 0.0:
        solved = _constraint_force(m, d, int(state.tendon))
        state.previous_constraint = state.constraint_force
        follows = 1.0 if state.inextensible != 0.0 else _FOLLOWS
        state.constraint_force += follows * (solved - state.constraint_force)


@compiled
def _stiffness_times_length(m: Model, tendon: int, length: float) -> float:
    """k S of a tendon's own spring [N], k = T/x of a polynomial at the length at hand."""
    rest = m.tendon_lengthspring[tendon, 1]
    linear = m.tendon_stiffness[tendon]
    poly = m.tendon_stiffnesspoly[tendon]
    return mju_polyForce(linear, poly, max(0.0, length - rest), _POLY, 0) * rest


@apart
def note_spring(m: Model, state: State, has_length: bool) -> None:
    """Derive EA, and T_0 or the slack, from the tendon's own spring, unless they are configured."""
    tendon = int(state.tendon)
    rest = m.tendon_lengthspring[tendon, 1]
    stiffness = m.tendon_stiffness[tendon]
    length = m.tendon_length0[tendon]
    state.spring_length = rest
    state.spring_product = max(0.0, _stiffness_times_length(m, tendon, length))
    if state.law.axial_stiffness == 0.0:
        state.law.axial_stiffness = state.spring_product
    if not has_length:
        state.law.pretension = max(0.0, stiffness * (length - rest))
        state.law.slack = rest - length if rest > length * (1.0 + _SAME) else 0.0


@compiled
def follow_spring(m: Model, d: Data, state: State) -> bool:
    """Follow the tendon's own spring as `mjModel` now has it; return whether it can pull.

    EA changes in the ratio in which k S does.
    """
    tendon = int(state.tendon)
    length = d.ten_length[tendon]
    product = _stiffness_times_length(m, tendon, length)
    off = m.opt.disableflags & _SPRING_OFF != 0
    state.input_force = 0.0 if off else _spring(m, d, tendon)
    if state.spring_product > 0.0 and product != state.spring_product:
        if not product > 0.0:
            return False
        is_own = state.law.axial_stiffness == state.spring_product
        grown = state.law.axial_stiffness * (product / state.spring_product)
        state.law.axial_stiffness = product if is_own else grown
        state.spring_product = product
    return not off
