"""Kernels of the acceleration stage: constraint forces, reactions of the spans, sensors.

As the plugin's. MuJoCo Warp counts one tension along each tendon in `cfrc_ext` and `cfrc_int`;
every span adds the wrench of its difference. Both arrays may be there already from an earlier call,
so the written numbers are kept: numbers that are the same have their wrench.
"""

import mujoco_warp as mjw
import warp as wp

from tendon_mj.warp.groups import Groups
from tendon_mj.warp.tendons import Tendons, unstretched

wp.set_module_options({"enable_backward": False})

_OF_TENDONS = wp.constant(3)  # mjtEq
_TENDON_LIMIT = wp.constant(4)  # mjtConstraint
FORCE, TORQUE = 4, 5  # mjtSensor
_REAL = wp.constant(0)  # mjtDataType
_EQUALITY = mjw.Model.__annotations__["eq_data"].dtype  # 12 numbers, before MuJoCo 3.17 11
TENSION, ANGLE, SLIP, SLIDE, WOUND, UNSOLVED = range(6)  # SLIDE: the slip of a cell


@wp.struct
class Solved:
    """Constraints, and the tendons along which they pull."""

    eq_type: wp.array[wp.int32]
    eq_obj1id: wp.array[wp.int32]
    eq_obj2id: wp.array[wp.int32]
    eq_data: wp.array2d[_EQUALITY]
    tendon_range: wp.array2d[wp.vec2]
    tendon_length0: wp.array2d[wp.float32]
    ten_length: wp.array2d[wp.float32]
    ne: wp.array[wp.int32]
    nf: wp.array[wp.int32]
    nl: wp.array[wp.int32]
    type: wp.array2d[wp.int32]
    id: wp.array2d[wp.int32]
    force: wp.array2d[wp.float32]


@wp.func
def _of_equality(c: Solved, row: int, tendon: int, w: int) -> float:
    which = c.id[w, row]
    force = float(0.0)
    if c.eq_type[which] != _OF_TENDONS:
        return force
    if c.eq_obj1id[which] == tendon:
        force += c.force[w, row]
    if c.eq_obj2id[which] == tendon:
        x = c.ten_length[w, tendon] - c.tendon_length0[w % c.tendon_length0.shape[0], tendon]
        p = c.eq_data[w % c.eq_data.shape[0], which]
        slope = p[1] + x * (2.0 * p[2] + x * (3.0 * p[3] + x * 4.0 * p[4]))
        force -= c.force[w, row] * slope
    return force


@wp.func
def _of_limit(c: Solved, row: int, tendon: int, w: int) -> float:
    if c.type[w, row] != _TENDON_LIMIT or c.id[w, row] != tendon:
        return 0.0
    length, ends = c.ten_length[w, tendon], c.tendon_range[w % c.tendon_range.shape[0], tendon]
    return wp.where(length - ends[0] < ends[1] - length, c.force[w, row], -c.force[w, row])


@wp.kernel
def note_constraints(c: Solved, t: Tendons) -> None:
    """Note the force of equalities and limits along tendons; threads (sheaths, worlds)."""
    k, w = wp.tid()
    if not t.constrained[k]:
        return
    total = float(0.0)
    rows = c.id.shape[1]  # there are fewer where the room for constraints is used up
    for row in range(wp.min(c.ne[w], rows)):
        total += _of_equality(c, row, t.tendon[k], w)
    begin = c.ne[w] + c.nf[w]
    for row in range(begin, wp.min(begin + c.nl[w], rows)):
        total += _of_limit(c, row, t.tendon[k], w)
    t.solved_force[k, w] = wp.float64(total)


@wp.func
def _wrench(at: wp.vec3, centre: wp.vec3, force: wp.vec3) -> wp.spatial_vector:
    return wp.spatial_vector(wp.cross(at - centre, force), force)


@wp.func
def _add_once(
    total: wp.array2d[wp.spatial_vector],
    written: wp.array2d[wp.spatial_vector],
    w: int,
    body: int,
    wrench: wp.spatial_vector,
) -> None:
    """Add a wrench, unless the sum stands there from the last call."""
    value = total[w, body]
    before = written[w, body]
    summed = value + wrench  # `value` alone would be read when it is used
    same = bool(True)
    changes = bool(False)
    for i in range(6):
        same = same and value[i] == before[i]
        changes = changes or wrench[i] != 0.0
    if not changes:
        written[w, body] = wp.spatial_vector(wp.nan, wp.nan, wp.nan, wp.nan, wp.nan, wp.nan)
    elif not same:
        total[w, body] = summed
        written[w, body] = summed


@wp.func
def _carries(behind: wp.array[wp.int32], body: int, other: int) -> bool:
    return other > 0 and body <= other and other < behind[body]


@wp.kernel
def add_reactions(
    t: Tendons,
    behind: wp.array[wp.int32],
    rootid: wp.array[wp.int32],
    subtree_com: wp.array2d[wp.vec3],
    written_ext: wp.array2d[wp.spatial_vector],
    written_int: wp.array2d[wp.spatial_vector],
    cfrc_ext: wp.array2d[wp.spatial_vector],
    cfrc_int: wp.array2d[wp.spatial_vector],
) -> None:
    """Add the wrenches of all spans; threads (bodies, worlds).

    ``behind`` is the number of the first body after those that a body carries. A span both of whose
    ends a body carries does not pass the body's joint.
    """
    body, w = wp.tid()
    outer = wp.spatial_vector()
    inner = wp.spatial_vector()
    for row in range(t.sheath.shape[0]):
        pull = wp.float32(t.pull[row, w])
        near, far = t.near_body[row, w], t.far_body[row, w]
        if near != far and pull != 0.0:
            start, force = t.start[row, w], pull * t.along[row, w]
            on_near = _wrench(start, subtree_com[w, rootid[near]], force)
            on_far = _wrench(start, subtree_com[w, rootid[far]], -force)
            carries_near = _carries(behind, body, near)
            carries_far = _carries(behind, body, far)
            if not (carries_near and carries_far and rootid[near] == rootid[far]):
                if carries_near:
                    inner -= on_near
                if carries_far:
                    inner -= on_far
            if body > 0 and body == near:
                outer += on_near
            if body > 0 and body == far:
                outer += on_far
    _add_once(cfrc_ext, written_ext, w, body, outer)
    _add_once(cfrc_int, written_int, w, body, inner)


@wp.struct
class Cells:
    """Sensors of force and torque, and where they are."""

    sensor_type: wp.array[wp.int32]
    sensor_datatype: wp.array[wp.int32]
    sensor_objid: wp.array[wp.int32]
    sensor_adr: wp.array[wp.int32]
    sensor_cutoff: wp.array[wp.float32]
    site_bodyid: wp.array[wp.int32]
    body_rootid: wp.array[wp.int32]
    site_xpos: wp.array2d[wp.vec3]
    site_xmat: wp.array2d[wp.mat33]
    subtree_com: wp.array2d[wp.vec3]
    cfrc_int: wp.array2d[wp.spatial_vector]


@wp.kernel
def fill_sensors(sensors: wp.array[wp.int32], m: Cells, sensordata: wp.array2d[wp.float32]) -> None:
    """Fill sensors of force and torque, as MuJoCo Warp does; threads (sensors, worlds)."""
    k, w = wp.tid()
    sensor = sensors[k]
    site = m.sensor_objid[sensor]
    body = m.site_bodyid[site]
    value = wp.spatial_bottom(m.cfrc_int[w, body])
    if m.sensor_type[sensor] != FORCE:
        arm = m.site_xpos[w, site] - m.subtree_com[w, m.body_rootid[body]]
        value = wp.spatial_top(m.cfrc_int[w, body]) - wp.cross(arm, value)
    value = wp.transpose(m.site_xmat[w, site]) * value
    cutoff = m.sensor_cutoff[sensor]
    limited = cutoff > 0.0 and m.sensor_datatype[sensor] == _REAL
    for i in range(3):
        shown = wp.where(limited, wp.clamp(value[i], -cutoff, cutoff), value[i])
        sensordata[w, m.sensor_adr[sensor] + i] = shown


@wp.kernel
def measure(
    t: Tendons, y: Groups, shown: wp.array2d[wp.int32], sensordata: wp.array2d[wp.float32]
) -> None:
    """Write each number that a sensor shows, see `shown_numbers`; threads (numbers, worlds)."""
    k, w = wp.tid()
    quantity, row = shown[k, 0], shown[k, 1]
    value = wp.float32(0.0)
    if quantity == TENSION:
        value = t.tension_out[w, row]
    elif quantity == ANGLE:
        value = wp.float32(t.angle[row, w])
    elif quantity == SLIP:
        if t.flow[row, w] != wp.float64(0.0):
            value = wp.float32(t.slip[row, w])
    elif quantity == SLIDE:
        if row >= 0 and y.flows[row, w]:
            value = -wp.float32(y.slides[row, w])
    elif quantity == WOUND:
        value = wp.float32(t.trial_wound_in[row, w] / unstretched(t, row, w, wp.float64(1.0)))
    else:
        value = wp.float32(t.unsolved[w, row])
    sensordata[w, shown[k, 2]] = value
