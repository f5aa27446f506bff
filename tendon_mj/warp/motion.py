"""From tensions to forces on the degrees of freedom, and from controls to pulls."""

import mujoco_warp as mjw
import warp as wp

from tendon_mj.warp.tendons import Tendons

wp.set_module_options({"enable_backward": False})

_TENDON = wp.constant(3)  # mjtTrn
_PARAMETERS = mjw.Model.__annotations__["actuator_biasprm"].dtype


@wp.struct
class Dynamics:
    """Joints, actuators and options of a model; state, inertia and forces of its worlds."""

    # of the model
    timestep: wp.array[wp.float32]
    nv: wp.int32
    body_rootid: wp.array[wp.int32]
    body_isdofancestor: wp.array2d[wp.int32]
    dof_invweight0: wp.array2d[wp.float32]
    jnt_qposadr: wp.array[wp.int32]
    jnt_dofadr: wp.array[wp.int32]
    qpos0: wp.array2d[wp.float32]
    M_rownnz: wp.array[wp.int32]
    M_rowadr: wp.array[wp.int32]
    M_colind: wp.array[wp.int32]
    dof_damping: wp.array2d[wp.float32]
    tendon_length0: wp.array2d[wp.float32]
    tendon_stiffness: wp.array2d[wp.float32]
    tendon_damping: wp.array2d[wp.float32]
    tendon_lengthspring: wp.array2d[wp.vec2]
    tendon_actuatorid: wp.array[wp.int32]  # which damps it: -1 none, below that all on it
    actuates: wp.bool  # whether the option leaves actuators on
    clamps: wp.bool  # whether it leaves controls within their ranges
    actuator_ctrllimited: wp.array[wp.bool]
    actuator_ctrlrange: wp.array2d[wp.vec2]
    spring: wp.float32  # 1 if the option leaves springs on, else 0
    damper: wp.float32
    nactuator: wp.int32
    actuator_trntype: wp.array[wp.int32]
    actuator_trnid: wp.array[wp.vec2i]
    actuator_gear: wp.array2d[wp.spatial_vector]
    actuator_damping: wp.array2d[wp.float32]  # before 4.0 in `tendon_damping`
    actuator_biasprm: wp.array2d[_PARAMETERS]
    actuator_forcelimited: wp.array[wp.bool]
    actuator_forcerange: wp.array2d[wp.vec2]
    joints_damp: wp.bool  # whether dampers of joints are integrated implicitly
    implicit: wp.bool  # whether those of actuators and tendons are
    has_forces: wp.bool  # whether there are forces of actuators yet
    # of the worlds
    time: wp.array[wp.float32]
    qpos: wp.array2d[wp.float32]
    ctrl: wp.array2d[wp.float32]
    ten_length: wp.array2d[wp.float32]
    ten_velocity: wp.array2d[wp.float32]
    actuator_force: wp.array2d[wp.float32]
    moment_rownnz: wp.array2d[wp.int32]
    moment_rowadr: wp.array2d[wp.int32]
    moment_colind: wp.array2d[wp.int32]
    actuator_moment: wp.array2d[wp.float32]
    M: wp.array2d[wp.float32]
    qvel: wp.array2d[wp.float32]
    qfrc_passive: wp.array2d[wp.float32]
    qfrc_actuator: wp.array2d[wp.float32]
    qfrc_applied: wp.array2d[wp.float32]
    qfrc_bias: wp.array2d[wp.float32]
    subtree_com: wp.array2d[wp.vec3]
    cdof: wp.array2d[wp.spatial_vector]


@wp.func
def span_jacobian(b: Dynamics, t: Tendons, row: int, w: int, dof: int) -> float:
    """∂ℓ/∂q of a segment's straight span, 0 for a dof that moves both its ends or neither."""
    near, far = int(t.near_body[row, w]), int(t.far_body[row, w])
    moves_near, moves_far = b.body_isdofancestor[near, dof], b.body_isdofancestor[far, dof]
    if moves_near == moves_far:
        return 0.0
    u = t.along[row, w]
    body = wp.where(moves_far != 0, far, near)
    r = t.start[row, w] - b.subtree_com[w, b.body_rootid[body]]
    motion = b.cdof[w, dof]
    turns, moves = wp.spatial_top(motion), wp.spatial_bottom(motion)
    value = wp.dot(turns, wp.cross(r, u)) + wp.dot(moves, u)
    return wp.where(moves_far != 0, value, -value)


@wp.func
def wound(b: Dynamics, joint: int, radius: wp.float64, w: int) -> wp.float64:
    """Tendon that a spool on a joint has wound in since `qpos0` [m]; 0 without a joint."""
    if joint < 0:
        return wp.float64(0.0)
    adr = b.jnt_qposadr[joint]
    return radius * wp.float64(b.qpos[w, adr] - b.qpos0[w % b.qpos0.shape[0], adr])


@wp.func
def reeled(b: Dynamics, control: int, output: int, w: int) -> wp.float64:
    """Control of a reel, within its range, times its gear [m]; 0 without a reel that actuates."""
    if output < 0 or not b.actuates:
        return wp.float64(0.0)
    value = b.ctrl[w, control]
    if b.clamps and b.actuator_ctrllimited[control]:
        limits = b.actuator_ctrlrange[w % b.actuator_ctrlrange.shape[0], control]
        value = wp.clamp(value, limits[0], limits[1])
    gear = b.actuator_gear[w % b.actuator_gear.shape[0], output][0]
    return wp.float64(gear) * wp.float64(value)


@wp.func
def rest_length(b: Dynamics, tendon: int, w: int) -> float:
    """Length beyond which the tendon's own spring pulls [m]."""
    return b.tendon_lengthspring[w % b.tendon_lengthspring.shape[0], tendon][1]


@wp.func
def tendon_spring(b: Dynamics, tendon: int, w: int) -> float:
    """Stiffness of the tendon's own spring [N/m]."""
    return b.tendon_stiffness[w % b.tendon_stiffness.shape[0], tendon]


@wp.func
def spring_force(b: Dynamics, tendon: int, w: int) -> float:
    """Force along the tendon by its own spring [N]; negative pulls."""
    length, longest = b.ten_length[w, tendon], rest_length(b, tendon, w)
    shortest = b.tendon_lengthspring[w % b.tendon_lengthspring.shape[0], tendon][0]
    x = wp.where(length > longest, length - longest, wp.min(0.0, length - shortest))
    return -b.spring * x * tendon_spring(b, tendon, w)


@wp.func
def input_force(b: Dynamics, tendon: int, w: int) -> wp.float64:
    """Force along the tendon [N] by actuators, its spring and its damper; negative pulls."""
    force = spring_force(b, tendon, w)
    damping = float(b.tendon_damping[w % b.tendon_damping.shape[0], tendon])
    damps = int(-1)
    if b.tendon_actuatorid.shape[0] > 0:
        damps = b.tendon_actuatorid[tendon]
    for a in range(b.nactuator):
        if b.actuator_trntype[a] == _TENDON and b.actuator_trnid[a][0] == tendon:
            gear = b.actuator_gear[w % b.actuator_gear.shape[0], a][0]
            force += gear * b.actuator_force[w, a]
            if damps == a or damps < -1:
                damping += gear * gear * b.actuator_damping[w % b.actuator_damping.shape[0], a]
    return wp.float64(force - b.damper * damping * b.ten_velocity[w, tendon])
