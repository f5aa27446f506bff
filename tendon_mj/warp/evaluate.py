"""Kernels: tensions of elastic tendons in all worlds, and the forces on the degrees of freedom.

An evaluation starts from the committed state. It leaves its result on trial, which the next
evaluation commits once time has gone on: stepping needs no separate call for that, and evaluating
twice in a step does no harm. If time has gone back the world was reset, and so is the tendon.

What is done for each segment by itself is done by a thread for each: `commit`, then `trace` for
each sheath, `prepare` for each segment, `solve` for each sheath, and `apply` for each degree of
freedom.
"""

import warp as wp

from tendon_mj.warp.motion import (
    Dynamics,
    input_force,
    reeled,
    rest_length,
    span_jacobian,
    spring_force,
    tendon_spring,
    wound,
)
from tendon_mj.warp.path import Scene, trace_path
from tendon_mj.warp.solver import solve_flow
from tendon_mj.warp.tendons import (
    ELASTIC,
    HALF,
    INEXTENSIBLE,
    ONE,
    ZERO,
    Sheath,
    Tendons,
    capstan,
    follow_speed,
    reset_sheath,
    set_alone,
    set_guide,
    sheath_at,
    unstretched,
    yielded,
)

wp.set_module_options({"enable_backward": False})

_RIGIDITY = wp.constant(wp.float64(0.25))  # of a drum's flank: see the plugin's `drive`
_FOLLOWS = wp.constant(wp.float64(0.2))  # see the plugin's `input_force`
_ROUNDED_LENGTH = wp.constant(wp.float64(1e-7))  # relative, rounding of single precision
_ROUNDED_PRODUCT = wp.constant(wp.float64(1e-6))


@wp.func
def _has_ended(t: Tendons, k: int, w: int, now: wp.float32) -> bool:
    """Return whether a step is on trial that has ended."""
    return t.has_trial[k, w] and now > t.trial_time[k, w]


@wp.kernel
def commit(
    time: wp.array[wp.float32], timestep: wp.array[wp.float32], t: Tendons, kind: int
) -> None:
    """Make what ended steps left in segments the committed state; threads (segments, worlds)."""
    row, w = wp.tid()
    k = t.sheath[row]
    if t.kind[k] != kind or not _has_ended(t, k, w, time[w]):
        return
    j = row - t.first_segment[k]
    guide, last = t.first_guide[k] + j, t.guides[k]
    tension = wp.float64(t.tension[row, w])
    stored = wp.float64(t.stored[row, w])
    if j == 0:
        stored -= t.trial_wound_in[k, w] - t.wound_in[k, w]
    if j == last:
        stored -= t.trial_wound_out[k, w] - t.wound_out[k, w]
    if j == 0:
        stored += t.trial_spring_length[k, w] - t.spring_length[k, w]
    if j > 0:
        stored -= t.flow[guide - 1, w] + t.shift[guide - 1, w]
    if j < last:
        flow = wp.float64(t.flow[guide, w])
        stored += flow + t.shift[guide, w]
        t.previous_slip[guide, w] = wp.where(flow != ZERO, t.slip[guide, w], 0)
        h = wp.float64(timestep[w % timestep.shape[0]])
        follow_speed(t, k, guide, flow / h, h, w)
    stored += yielded(t, row, tension, w) - yielded(t, row, wp.float64(t.before[row, w]), w)
    if j == 0 and kind == ELASTIC:  # the input's tension sets its length
        stored = t.length[row, w] / (ONE + tension)
    t.stored[row, w] = stored
    t.before[row, w] = tension


@wp.func
def _commit_ends(t: Tendons, k: int, w: int) -> None:
    """Make what an ended step left at the ends and on the geoms the committed state."""
    arc = int(t.first_arc[k])
    behind = wp.where(k + 1 < t.first_arc.shape[0], t.first_arc[k + 1], t.touched.shape[0])
    while arc < behind:
        t.touched[arc, w] = t.trial_touches[arc, w]
        t.near_tangent[arc, w] = t.trial_near[arc, w]
        t.far_tangent[arc, w] = t.trial_far[arc, w]
        arc += 1
    t.spring_length[k, w] = t.trial_spring_length[k, w]
    t.constraint_force[k, w] += _FOLLOWS * (t.solved_force[k, w] - t.constraint_force[k, w])
    t.wound_in[k, w] = t.trial_wound_in[k, w]
    t.wound_out[k, w] = t.trial_wound_out[k, w]
    t.has_trial[k, w] = False


@wp.func
def _rest(b: Dynamics, t: Tendons, s: Sheath) -> wp.float64:
    """Rest length of the tendon's own spring as the model on the device now has it [m]."""
    before = t.spring_length[s.index, s.world]
    now = wp.float64(rest_length(b, t.tendon[s.index], s.world))
    return wp.where(wp.abs(now - before) <= _ROUNDED_LENGTH * before, before, now)


@wp.func
def _follow_stiffness(b: Dynamics, t: Tendons, s: Sheath) -> bool:
    """Let EA follow k S of the tendon's own spring; return whether that can pull."""
    k, w = s.index, s.world
    tendon = t.tendon[k]
    before = t.spring_product[k, w]
    now = wp.float64(tendon_spring(b, tendon, w)) * wp.float64(rest_length(b, tendon, w))
    if before > ZERO and not wp.abs(now - before) <= _ROUNDED_PRODUCT * before:
        if not now > ZERO:
            return False
        ea = wp.float64(t.axial_stiffness[w, k])
        is_own = wp.abs(ea - before) <= _ROUNDED_PRODUCT * before
        t.axial_stiffness[w, k] = wp.float32(wp.where(is_own, now, ea * now / before))
        t.spring_product[k, w] = now
    return b.spring != 0.0


@wp.func
def _counted(b: Dynamics, t: Tendons, s: Sheath) -> wp.float64:
    """Force with which MuJoCo Warp pulls by the spring of which the sheath is made [N]."""
    k = s.index
    pull = -wp.float64(spring_force(b, t.tendon[k], s.world))
    if t.reel_joint[k] >= 0 or t.output_joint[k] >= 0 or t.reel[k] >= 0:
        return pull  # the spring does not count the tendon on the drum
    return wp.max(ZERO, pull)


@wp.func
def _pull_nothing(t: Tendons, s: Sheath, now: wp.float32) -> None:
    """Add no force and commit nothing."""
    k, w = s.index, s.world
    t.has_trial[k, w] = False
    t.trial_time[k, w] = now
    for j in range(s.guides + 1):
        t.pull[s.segment + j, w] = ZERO
    t.reel_torque[k, w] = ZERO
    t.output_torque[k, w] = ZERO


@wp.func
def _lay(b: Dynamics, t: Tendons, s: Sheath, tau: wp.float64, rest: wp.float64) -> None:
    """Initialise the segments: under τ if that is given, else with the length it has."""
    k, w = s.index, s.world
    total = wp.float64(0.0)
    for j in range(s.guides + 1):
        total += t.length[s.segment + j, w]
    strain = tau
    free = wp.float64(0.0)
    if not s.given:
        length0 = b.tendon_length0[w % b.tendon_length0.shape[0], t.tendon[k]]
        t.laid_pretension[k, w] = wp.float64(t.pretension[w, k])
        free = unstretched(t, k, w, wp.float64(length0) + wp.float64(t.slack[w, k]))
        if t.own_spring[k]:
            free = rest + t.beyond_spring[k]
            t.spring_length[k, w] = rest
        t.wound_in[k, w] = wound(b, t.reel_joint[k], unstretched(t, k, w, t.reel_radius[k]), w)
        wound_out = wound(b, t.output_joint[k], unstretched(t, k, w, t.output_radius[k]), w)
        t.wound_out[k, w] = wound_out
        free -= t.wound_in[k, w] + wound_out
        strain = total / free - ONE
    for j in range(s.guides + 1):
        row = s.segment + j
        t.stored[row, w] = t.length[row, w] / (ONE + strain)
        t.before[row, w] = strain
    for i in range(s.guides):
        t.previous_slip[s.guide + i, w] = 0
    t.started[k, w] = True


@wp.func
def _reset(t: Tendons, k: int, w: int) -> None:
    """Reset the state of a tendon."""
    reset_sheath(t, k, w)
    t.wound_in[k, w] = wp.float64(0.0)
    t.wound_out[k, w] = wp.float64(0.0)
    t.laid_pretension[k, w] = wp.float64(0.0)
    if t.kind[k] == INEXTENSIBLE:
        return
    behind = wp.where(k + 1 < t.first_arc.shape[0], t.first_arc[k + 1], t.touched.shape[0])
    for arc in range(t.first_arc[k], behind):
        t.touched[arc, w] = False


@wp.kernel
def reset_worlds(t: Tendons, worlds: wp.array[wp.bool]) -> None:
    """Reset the tendons of some worlds; threads (sheaths, worlds)."""
    k, w = wp.tid()
    if worlds[w]:
        _reset(t, k, w)


@wp.kernel
def finish(time: wp.array[wp.float32], t: Tendons) -> None:
    """Commit what `commit` does not; threads (sheaths, worlds)."""
    k, w = wp.tid()
    if t.kind[k] != INEXTENSIBLE and _has_ended(t, k, w, time[w]):
        _commit_ends(t, k, w)


@wp.func
def _hold_none(t: Tendons, s: Sheath, now: wp.float32) -> None:
    """Let a tendon whose own spring cannot pull have no tension."""
    k, w = s.index, s.world
    for j in range(s.guides + 1):
        t.tension_out[w, t.first_shown[k] + j] = wp.float32(0.0)
    t.input_tension[w, k] = wp.float32(0.0)
    t.output_tension[w, k] = wp.float32(0.0)
    _pull_nothing(t, s, now)


@wp.func
def _on_drum(b: Dynamics, t: Tendons, s: Sheath, ea: wp.float64) -> wp.float64:
    """Tendon on the drum behind its play, and what its drive bears: see the plugin's `drive`."""
    k, w = s.index, s.world
    joint, radius = t.reel_joint[k], unstretched(t, k, w, t.reel_radius[k])
    play = unstretched(t, k, w, wp.float64(t.backlash[w, k]))
    drive = wound(b, joint, radius, w)
    drive += unstretched(t, k, w, reeled(b, t.reel[k], t.reel_output[k], w))
    t.drive_bears[k, w] = wp.float64(wp.inf)
    if play == ZERO or not wp.isfinite(drive):
        return drive
    softness = wp.float64(0.0)  # of the flank [m/N]
    if joint >= 0:
        mobility = b.dof_invweight0[w % b.dof_invweight0.shape[0], b.jnt_dofadr[joint]]
        reach = wp.float64(b.timestep[w % b.timestep.shape[0]]) * radius
        softness = wp.float64(mobility) * reach * reach / _RIGIDITY
    strain = wp.max(ZERO, t.before[s.segment, w])
    pull = ea * strain * (ONE + HALF * strain)
    least, most = drive - HALF * play - pull * softness, drive + HALF * play
    on_drum = wp.min(wp.max(t.wound_in[k, w], least), most)
    if joint >= 0:
        pressed = wp.max(ZERO, drive - on_drum - HALF * play)
        t.drive_bears[k, w] = wp.abs(radius) * pressed / softness
    return on_drum


@wp.kernel
def trace(m: Scene, b: Dynamics, t: Tendons, kind: int) -> None:
    """Paths of the sheaths of a kind; threads (sheaths, worlds)."""
    k, w = wp.tid()
    if t.kind[k] != kind:
        return
    s = sheath_at(t, k, w)
    now = b.time[w]
    t.active[k, w] = False
    if t.started[k, w] and now < t.trial_time[k, w]:
        _reset(t, k, w)
    elif _has_ended(t, k, w, now):
        _commit_ends(t, k, w)
    trace_path(m, t, s)
    rest = wp.float64(0.0)
    pulls = bool(True)
    if t.own_spring[k]:
        rest = _rest(b, t, s)
        pulls = _follow_stiffness(b, t, s)
    ea = wp.float64(t.axial_stiffness[w, k])
    tau = wp.float64(0.0)
    if kind == ELASTIC:
        force = input_force(b, t.tendon[k], w) + t.constraint_force[k, w]
        if not wp.isfinite(force):
            t.unsolved[w, k] += 1
            _pull_nothing(t, s, now)
            return
        tau = wp.max(ZERO, -force) / ea
    if not t.started[k, w]:
        _lay(b, t, s, tau, rest)
    if not pulls:
        _hold_none(t, s, now)
        return
    wound_in = _on_drum(b, t, s, ea)
    wound_out = wound(b, t.output_joint[k], unstretched(t, k, w, t.output_radius[k]), w)
    if not wp.isfinite(wound_in + wound_out):
        t.unsolved[w, k] += 1
        _pull_nothing(t, s, now)
        return
    t.given_tension[k, w] = tau
    t.trial_wound_in[k, w] = wound_in
    t.trial_wound_out[k, w] = wound_out
    t.trial_spring_length[k, w] = rest
    t.trial_time[k, w] = now
    t.active[k, w] = True


@wp.kernel
def prepare(t: Tendons, kind: int) -> None:
    """Lengths before anything flows, a guess of the tensions, and ratios that the guides can hold.

    Threads (segments, worlds).
    """
    row, w = wp.tid()
    k = t.sheath[row]
    if t.kind[k] != kind or not t.active[k, w]:
        return
    j = row - t.first_segment[k]
    guide, last = t.first_guide[k] + j, t.guides[k]
    kept, tau = wp.float64(t.stored[row, w]), wp.float64(t.before[row, w])
    if j < last:
        kept += t.shift[guide, w]
    if j > 0:
        kept -= t.shift[guide - 1, w]
    if j == 0:
        kept -= t.trial_wound_in[k, w] - t.wound_in[k, w]
        kept += t.trial_spring_length[k, w] - t.spring_length[k, w]
        tau = wp.where(kind == ELASTIC, t.given_tension[k, w], tau)
    if j == last:
        kept -= t.trial_wound_out[k, w] - t.wound_out[k, w]
    t.kept[row, w] = kept - yielded(t, row, wp.float64(t.before[row, w]), w)
    t.tension[row, w] = tau
    set_alone(t, row, w)
    if j == last:
        return
    dynamic, highest, constant = capstan(t, guide, k, w)
    set_guide(t, guide, w, dynamic, highest, constant / wp.float64(t.axial_stiffness[w, k]))


@wp.func
def _publish(t: Tendons, s: Sheath, ea: wp.float64, counted: wp.float64) -> bool:
    """Write tensions, and forces of which MuJoCo has ``counted``; whether all are finite."""
    k, w = s.index, s.world
    bounded = bool(True)
    for j in range(s.guides + 1):
        row = s.segment + j
        tension = ea * t.tension[row, w]
        t.tension_out[w, t.first_shown[k] + j] = wp.float32(tension)
        t.pull[row, w] = tension - counted
        bounded = bounded and wp.isfinite(tension)
    first, final = t.tension[s.segment, w], t.tension[s.segment + s.guides, w]
    t.input_tension[w, k] = wp.float32(ea * first)
    t.output_tension[w, k] = wp.float32(ea * final)
    torque = unstretched(t, k, w, t.reel_radius[k]) * ea * first * (ONE + HALF * first)
    t.reel_torque[k, w] = wp.min(wp.max(torque, -t.drive_bears[k, w]), t.drive_bears[k, w])
    radius = unstretched(t, k, w, t.output_radius[k])
    t.output_torque[k, w] = radius * ea * final * (ONE + HALF * final)
    return bounded


@wp.kernel(module="unique", module_options={"max_unroll": 0}, enable_backward=False)
def solve(b: Dynamics, t: Tendons, kind: int) -> None:
    """Tensions of the sheaths of a kind; threads (sheaths, worlds)."""
    k, w = wp.tid()
    if t.kind[k] != kind or not t.active[k, w]:
        return
    s = sheath_at(t, k, w)
    if not solve_flow(t, s):
        t.unsolved[w, k] += 1
    ea = wp.float64(t.axial_stiffness[w, k])
    counted = ea * t.given_tension[k, w]
    if t.own_spring[k]:
        counted = _counted(b, t, s)
    if _publish(t, s, ea, counted):
        t.has_trial[k, w] = True
    else:
        _pull_nothing(t, s, b.time[w])


@wp.kernel
def apply(
    b: Dynamics,
    t: Tendons,
    moved: wp.array2d[wp.bool],
    kind: int,
    qfrc: wp.array2d[wp.float32],
) -> None:
    """Add the forces of the sheaths of a kind; threads (dofs, worlds).

    A thread adds up the forces on its degree of freedom, always in the same order. ``moved``
    (sheaths, dofs) says whether one moves part of a tendon's path.
    """
    dof, w = wp.tid()
    total = wp.float64(0.0)
    for k in range(t.tendon.shape[0]):
        if t.kind[k] == kind:
            segments = wp.where(moved[k, dof], t.guides[k] + 1, 0)
            for j in range(segments):
                row = t.first_segment[k] + j
                pull = t.pull[row, w]
                if pull != ZERO:
                    total -= pull * wp.float64(span_jacobian(b, t, row, w, dof))
            if t.reel_joint[k] >= 0:
                if b.jnt_dofadr[t.reel_joint[k]] == dof:
                    total -= t.reel_torque[k, w]
            if t.output_joint[k] >= 0:
                if b.jnt_dofadr[t.output_joint[k]] == dof:
                    total -= t.output_torque[k, w]
    qfrc[w, dof] += wp.float32(total)
