"""Forces of the tendon on bodies and spools, and their share in MuJoCo's force sensors.

A straight span of length ℓ under tension T pulls its two ends together, which is −T J with
J = ∂ℓ/∂q. With u its direction and `mjData.cdof` the spatial velocity (ω, v) of dof i about c, the
centre of mass of the kinematic tree,

    J_i = ±(v · u + ω · ((p − c) × u))

+ where the dof moves the far end p, − where it moves the near one. A dof that moves both does not
change the length.

MuJoCo's actuators, springs and constraints act with one tension T_c along the whole tendon. A
sheath that they drive adds the difference that friction makes, T − T_c of each span, and nothing
if nothing rubs. One whose elasticity is the tendon's own spring adds T − k (L − S).

`mj_rnePostConstraint` adds the wrench of every spatial tendon under T_c from MuJoCo 3.14 on. Before
that it adds none, and T_c is added here, too. The difference pulls each end of a span along its
direction, F = ±(T − T_c) u at point p, which about c is the wrench ((p − c) × F, F). It is added to
`cfrc_ext` of the body, and taken from `cfrc_int`, the force that passes a body's joint, of that
body and of all that carry it. Sensors of `force` and `torque` are then filled again. MuJoCo
computes both arrays before it asks for sensors of the acceleration stage, unless they are there
already. One number of `cfrc_ext` with the wrenches is therefore kept: where it is still the same,
they have been added.
"""

from __future__ import annotations

import math

import mujoco

from tendon_mj.native import LocalDoubles, apart, compiled
from tendon_mj.plugin.abi.layout import Data, Model
from tendon_mj.plugin.abi.library import mj_version, mju_transformSpatial
from tendon_mj.plugin.abi.memory import doubles
from tendon_mj.plugin.sheath_plugin.attributes import is_sheath
from tendon_mj.plugin.sheath_plugin.bind import is_bound
from tendon_mj.plugin.sheath_plugin.input_force import uniform_force
from tendon_mj.plugin.sheath_plugin.state import (
    State,
    counted_strain,
    state_at,
    state_of,
    tension_unit,
    unpack,
)
from tendon_mj.plugin.sheath_plugin.strain import spool_torque
from tendon_mj.plugin.sheath_plugin.vectors import Vector
from tendon_mj.sheath import Segment, Segments
from tendon_mj.typing import FloatArray


@compiled
def _last_dof(m: Model, body: int) -> int:
    """The last degree of freedom that moves a body, −1 without one."""
    body = m.body_weldid[body]
    while body > 0 and m.body_dofnum[body] == 0:
        body = m.body_parentid[body]
    if body == 0:
        return -1
    count = m.body_dofnum[body]
    return m.body_dofadr[body] + count - 1


@compiled
def _span(d: Data, state: State, segment: Segment) -> tuple[int, Vector, float]:
    """Index of a span's near end in `wrap_xpos`, which the far one follows; their distance [m]."""
    p = d.wrap_xpos.flat
    k = 3 * (d.ten_wrapadr[int(state.tendon)] + int(segment.point))
    ux, uy, uz = p[k + 3] - p[k], p[k + 4] - p[k + 1], p[k + 5] - p[k + 2]
    return k, (ux, uy, uz), math.sqrt(ux * ux + uy * uy + uz * uz)


@compiled
def _pull(
    m: Model,
    d: Data,
    state: State,
    segment: Segment,
    tension: float,
    force: FloatArray,
) -> None:
    """Add −T J of a segment's span to ``force``."""
    near = _last_dof(m, int(segment.near_body))
    far = _last_dof(m, int(segment.far_body))
    k, u, length = _span(d, state, segment)
    if length == 0.0:
        return
    ux, uy, uz = u[0] / length, u[1] / length, u[2] / length
    p = d.wrap_xpos.flat
    roots, parents = m.body_rootid, m.dof_parentid
    centres, motions = d.subtree_com, d.cdof
    for end in range(2):
        # the dofs of one end that are not the other's too: from the leaf to the common ancestor
        dof, other = (near, far) if end == 0 else (far, near)
        if dof < 0:
            continue
        body = int(segment.near_body) if end == 0 else int(segment.far_body)
        sign, at_end = (-1.0, k) if end == 0 else (1.0, k + 3)
        c = centres[roots[body]]
        rx, ry, rz = p[at_end] - c[0], p[at_end + 1] - c[1], p[at_end + 2] - c[2]
        tx, ty, tz = ry * uz - rz * uy, rz * ux - rx * uz, rx * uy - ry * ux
        while dof != other and dof >= 0:
            if other > dof:
                other = parents[other]
                continue
            s = motions[dof]
            value = s[0] * tx + s[1] * ty + s[2] * tz + s[3] * ux + s[4] * uy + s[5] * uz
            force[dof] -= sign * value * tension
            dof = parents[dof]


@compiled
def pull_segment(
    m: Model,
    d: Data,
    state: State,
    segment: Segment,
    tension: float,
    force: FloatArray,
) -> None:
    """Add the generalised force of a segment's span under a tension [N]; −1 adds J itself.

    A segment that connects no two bodies adds nothing.
    """
    if segment.point >= 0.0 and segment.near_body != segment.far_body:
        _pull(m, d, state, segment, tension, force)


@compiled
def _added(ea: float, counted: float, segment: Segment) -> float:
    """T − T_c of a segment [N]."""
    return ea * (segment.tension - counted / segment.divisor)


@compiled
def add_torque(m: Model, d: Data, joint: float, torque: float) -> None:
    """Add the torque that the tendon exerts on a spool's joint; nothing without a joint."""
    if joint >= 0.0:
        d.qfrc_passive[m.jnt_dofadr[int(joint)]] += torque


@compiled
def apply_forces(m: Model, d: Data, state: State, segments: Segments, force: FloatArray) -> None:
    """Add the tendon's forces on bodies along the path to ``force``; apply those on spools."""
    ea, counted, last = tension_unit(state), counted_strain(state), len(segments) - 1
    state.applied = 1.0
    for j in range(last + 1):
        tension = _added(ea, counted, segments[j])
        if tension != 0.0:
            pull_segment(m, d, state, segments[j], tension, force)
    if state.driven != 0.0:
        return
    add_torque(m, d, state.reel_joint, -state.reel_torque)
    torque = spool_torque(state, segments, last, state.output_radius)
    add_torque(m, d, state.output_joint, -torque)


_FORCE = mujoco.mjtSensor.mjSENS_FORCE.value
_TORQUE = mujoco.mjtSensor.mjSENS_TORQUE.value
_REAL = mujoco.mjtDataType.mjDATATYPE_REAL.value
_COUNTS_TENDONS = 3014000  # first `mj_version` whose `mj_rnePostConstraint` has tendons
_vector6 = LocalDoubles(6)


@compiled
def _is_applied(m: Model, d: Data, instance: int, skipped: bool) -> bool:
    """Return whether the state of a sheath holds the forces that act in this step."""
    if not is_bound(m, d, instance):
        return False
    state = state_at(state_of(m, d, instance))
    return state.applied != 0.0 and not (skipped and state.driven != 0.0)


@compiled
def _add(m: Model, d: Data, body: int, top: int, p: FloatArray, at: int, force: FloatArray) -> int:
    """Add the wrench of a force at a point to a body; return the index of its largest number.

    In `cfrc_int` it counts on the body and on all that carry it below ``top``, and on a ``top`` 0.
    """
    c = d.subtree_com[m.body_rootid[body]]
    x, y, z = p[at] - c[0], p[at + 1] - c[1], p[at + 2] - c[2]
    wrench = doubles(_vector6(), 6)
    wrench[0] = y * force[2] - z * force[1]
    wrench[1] = z * force[0] - x * force[2]
    wrench[2] = x * force[1] - y * force[0]
    wrench[3], wrench[4], wrench[5] = force[0], force[1], force[2]
    outer = d.cfrc_ext.flat
    inner = d.cfrc_int.flat
    largest = 0
    for k in range(6):
        outer[6 * body + k] += wrench[k]
        if abs(wrench[k]) > abs(wrench[largest]):
            largest = k
    carrier = body
    while carrier > top:
        for k in range(6):
            inner[6 * carrier + k] -= wrench[k]
        carrier = m.body_parentid[carrier]
    if top == 0:
        for k in range(6):
            inner[k] -= wrench[k]
    return 6 * body + largest


@compiled
def _common_body(m: Model, one: int, other: int) -> int:
    """The nearest body that carries both, or is one of them and carries the other."""
    parents = m.body_parentid
    while one != other:
        if one > other:
            one = parents[one]
        else:
            other = parents[other]
    return one


@compiled
def _add_span(m: Model, d: Data, state: State, segment: Segment, tension: float) -> int:
    """Add the wrenches of a span under a tension [N]; return an index that was added to, or −1."""
    near, far, bodies = int(segment.near_body), int(segment.far_body), m.nbody
    spans = d.ten_wrapnum[int(state.tendon)] - 1
    if not 0.0 <= segment.point < spans or near == far:
        return -1
    if not (0 <= near < bodies and 0 <= far < bodies):
        return -1
    k, u, length = _span(d, state, segment)
    if length == 0.0:
        return -1
    p, force = d.wrap_xpos.flat, doubles(_vector6(), 3)
    top, index = _common_body(m, near, far), -1
    for i in range(3):
        force[i] = tension * u[i] / length
    if near != 0:
        index = _add(m, d, near, top, p, k, force)
    if far != 0:
        for i in range(3):
            force[i] = -force[i]
        index = _add(m, d, far, top, p, k + 3, force)
    return index


@compiled
def _fill_sensor(m: Model, d: Data, sensor: int) -> None:
    """Fill a sensor of force or torque from `cfrc_int`, as MuJoCo does."""
    kind = m.sensor_type[sensor]
    site = m.sensor_objid[sensor]
    body = m.site_bodyid[site]
    at_site, centre = _vector6(), d.subtree_com[m.body_rootid[body]]
    mju_transformSpatial(at_site, d.cfrc_int[body], 1, d.site_xpos[site], centre, d.site_xmat[site])
    cutoff = m.sensor_cutoff[sensor]
    limited = cutoff > 0.0 and m.sensor_datatype[sensor] == _REAL
    for k in range(3):
        value = doubles(at_site, 6)[k + 3 if kind == _FORCE else k]
        d.sensordata[m.sensor_adr[sensor] + k] = (
            min(max(value, -cutoff), cutoff) if limited else value
        )


@compiled
def _shows_this_step(m: Model, d: Data, sensor: int) -> bool:
    """Return whether a sensor shows the present step, and not its history."""
    if m.sensor_history[sensor, 0] <= 0:
        return True
    if m.sensor_delay[sensor] > 0.0:
        return False
    interval = m.sensor_interval[sensor, 0]
    before = d.history[m.sensor_historyadr[sensor]]
    return interval <= 0.0 or before + interval <= d.time


@apart
def add_reactions(m: Model, d: Data, first: int, skipped: bool) -> None:
    """Add the wrenches of all sheaths, and fill the sensors that show them.

    The first sheath keeps the number that witnesses it; ``skipped``: MuJoCo skips passive forces.
    """
    keeper = state_at(state_of(m, d, first))
    numbers, witness = d.cfrc_ext.flat, keeper.witness
    is_index = 0.0 < witness < 6.0 * m.nbody
    if is_index and numbers[int(witness)] == keeper.witness_value:
        return
    keeper.witness, changed = 0.0, False
    counts_tendons = mj_version() >= _COUNTS_TENDONS
    for instance in range(first, m.nplugin):
        if not is_sheath(m, instance, first):
            continue
        if not _is_applied(m, d, instance, skipped):
            continue
        address = state_of(m, d, instance)
        state = state_at(address)
        segments, _, _ = unpack(address)
        counted, ea = counted_strain(state), tension_unit(state)
        uniform = 0.0 if counts_tendons else -uniform_force(m, d, address, state)
        for j in range(len(segments)):
            tension = _added(ea, counted, segments[j])
            if uniform != 0.0:
                tension += uniform / segments[j].divisor
            if tension != 0.0:
                index = _add_span(m, d, state, segments[j], tension)
                if index >= 0:
                    keeper.witness, changed = index, True
    if not changed:
        return
    keeper.witness_value = numbers[int(keeper.witness)]
    for sensor in range(m.nsensor):
        if m.sensor_type[sensor] in (_FORCE, _TORQUE) and _shows_this_step(m, d, sensor):
            _fill_sensor(m, d, sensor)
