"""All sheathed tendons of all worlds at one moment, as arrays on the device; law of a segment.

A tendon's n+1 segments lie in a row, and so do its n guides; guide i sits between segments i and
i+1. Rows come first and worlds second, so that threads of neighbouring worlds read neighbouring
numbers. Inextensible tendons come last, as they have a path but no stored length. As in
`tendon_mj.sheath` tensions are normalised, τ = T/EA, and a segment of a purely elastic tendon holds
the unstretched length

    s(τ) = (ℓ − g τ) / (1 + τ).

Lengths, tensions and flows are in double precision: the strain of a tendon is a difference of
lengths, of 1e-4 and less, which single precision would round by a thousandth.
"""

import warp as wp

wp.set_module_options({"enable_backward": False})

# what a sheath's tendon is: of given length, or with a given force at its input
WOUND, ELASTIC, INEXTENSIBLE = range(3)
ZERO, HALF, ONE, TWO, INF = (wp.float64(x) for x in (0.0, 0.5, 1.0, 2.0, wp.inf))
_HOLDS_ANYTHING = wp.constant(wp.float64(37.0))  # see `plugin.sheath_plugin.friction`
_MEMORY = wp.constant(wp.float64(0.02))  # the same [s]


@wp.struct
class Tendons:
    """State and work space of the sheaths; (segments, worlds), (guides, worlds) and so on."""

    # description of each sheath, (sheaths,); −1: none
    kind: wp.array[wp.int32]  # WOUND, ELASTIC or INEXTENSIBLE
    tendon: wp.array[wp.int32]
    first_segment: wp.array[wp.int32]
    first_shown: wp.array[wp.int32]  # of its segments in ``tension_out``
    sheath: wp.array[wp.int32]  # (segments,), that of a segment
    first_guide: wp.array[wp.int32]
    guides: wp.array[wp.int32]
    first_arc: wp.array[wp.int32]
    arc_guides: wp.array[wp.int32]
    inner_guides: wp.array[wp.int32]
    sharing: wp.array[wp.float64]  # number of guides that share F_c and φ_x
    step: wp.array[wp.int32]  # +1 if the path is followed as it is drawn, −1: from its last site
    constrained: wp.array[wp.bool]  # by a given force, and by equalities or a limit as well
    own_spring: wp.array[wp.bool]  # whether the tendon's own spring is the cable's elasticity
    beyond_spring: wp.array[wp.float64]  # unstretched length less the rest length of that [m]
    reel: wp.array[wp.int32]  # address of its control
    reel_output: wp.array[wp.int32]  # and of its output; −1 where its group is disabled
    reel_joint: wp.array[wp.int32]
    reel_radius: wp.array[wp.float64]  # [m]
    output_joint: wp.array[wp.int32]
    output_radius: wp.array[wp.float64]  # [m]
    # parameters, (worlds, sheaths)
    axial_stiffness: wp.array2d[wp.float32]  # EA [N]
    friction: wp.array2d[wp.float32]  # μ_d [-]
    static_friction: wp.array2d[wp.float32]  # μ_s; below μ_d it counts as that [-]
    constant_friction: wp.array2d[wp.float32]  # F_c [N]
    pretension: wp.array2d[wp.float32]  # T_0 [N]
    extra_bend: wp.array2d[wp.float32]  # φ_x [rad]
    slack: wp.array2d[wp.float32]  # s [m]
    backlash: wp.array2d[wp.float32]  # b [m]
    stribeck_friction: wp.array2d[wp.float32]  # Δμ [-]
    stribeck_velocity: wp.array2d[wp.float32]  # v_s [m/s]
    # committed state
    started: wp.array2d[wp.bool]  # (sheaths, worlds); INEXTENSIBLE: whether a step has ended
    stored: wp.array2d[wp.float64]  # s, unstretched length in a segment [m]
    before: wp.array2d[wp.float64]  # τ after the step before
    previous_slip: wp.array2d[wp.int32]  # of a guide: +1 to the input, −1, 0 at rest
    sliding_speed: wp.array2d[wp.float64]  # of a guide, seen through the memory of friction [m/s]
    wound_in: wp.array2d[wp.float64]  # (sheaths, worlds), unstretched length [m]
    wound_out: wp.array2d[wp.float64]
    laid_pretension: wp.array2d[wp.float64]  # under which the tendon was laid [N]
    spring_length: wp.array2d[wp.float64]  # rest length S of the tendon's own spring [m]
    spring_product: wp.array2d[wp.float64]  # k S of it [N]
    constraint_force: wp.array2d[wp.float64]  # λ of equalities and limits, negative pulls [N]
    previous_constraint: wp.array2d[wp.float64]  # in the step before [N]
    touched: wp.array2d[wp.bool]  # (arcs, worlds), whether the tendon lay on the geom
    near_tangent: wp.array2d[wp.vec3d]  # in the frame of the geom [m]
    far_tangent: wp.array2d[wp.vec3d]
    # of the step on trial, which the next one commits
    has_trial: wp.array2d[wp.bool]  # (sheaths, worlds)
    trial_time: wp.array2d[wp.float32]  # [s]
    trial_wound_in: wp.array2d[wp.float64]
    trial_wound_out: wp.array2d[wp.float64]
    drive_bears: wp.array2d[wp.float64]  # torque on a reel's joint, at most [N m]
    trial_spring_length: wp.array2d[wp.float64]
    solved_force: wp.array2d[wp.float64]  # λ as it was solved in that step [N]
    trial_touches: wp.array2d[wp.bool]
    trial_near: wp.array2d[wp.vec3d]
    trial_far: wp.array2d[wp.vec3d]
    shift: wp.array2d[wp.float64]  # tendon that a guide on an arc has moved past [m]
    tension: wp.array2d[wp.float64]  # τ
    flow: wp.array2d[wp.float64]  # that passes a guide to the input [m]
    slip: wp.array2d[wp.int32]
    # path
    length: wp.array2d[wp.float64]  # ℓ [m]
    give: wp.array2d[wp.float64]  # g, by which guides yield to a segment per unit τ [m]
    angle: wp.array2d[wp.float64]  # φ [rad]
    is_on_arc: wp.array2d[wp.bool]  # of a guide
    start: wp.array2d[wp.vec3]  # where the straight span of a segment begins [m]
    along: wp.array2d[wp.vec3]  # its direction
    near_body: wp.array2d[wp.int32]
    far_body: wp.array2d[wp.int32]  # the same where a segment has no span
    # flow problem
    active: wp.array2d[wp.bool]  # (sheaths, worlds), whether there is one
    given_tension: wp.array2d[wp.float64]  # τ of the first segment of an elastic tendon
    kept: wp.array2d[wp.float64]  # s before the flow of this step, after winding and shifts [m]
    alone: wp.array2d[wp.float64]  # τ of a segment whose guides hold
    dynamic_ratio: wp.array2d[wp.float64]  # e^{μ_d φ}
    input_ratio: wp.array2d[wp.float64]  # largest τ_i/τ_{i+1} that holds now
    input_inverse: wp.array2d[wp.float64]
    output_ratio: wp.array2d[wp.float64]  # largest τ_{i+1}/τ_i
    output_inverse: wp.array2d[wp.float64]
    constant: wp.array2d[wp.float64]  # F_c of a guide over EA
    # work space of the solver
    prefix: wp.array2d[wp.float64]  # τ* of the tendon cut behind a segment
    breakpoint: wp.array2d[wp.float64]  # (2 guides, worlds), τ before the map of its stack
    bend: wp.array2d[wp.float64]  # slope of G_j beyond it less slope before it [m]
    jump: wp.array2d[wp.float64]  # G_j beyond it less G_j before it [m]
    # results
    pull: wp.array2d[wp.float64]  # (segments, worlds), force that a span adds to MuJoCo's [N]
    reel_torque: wp.array2d[wp.float64]  # (sheaths, worlds) [N m]
    output_torque: wp.array2d[wp.float64]
    tension_out: wp.array2d[wp.float32]  # (worlds, segments), T [N]
    input_tension: wp.array2d[wp.float32]  # (worlds, sheaths) [N]
    output_tension: wp.array2d[wp.float32]
    unsolved: wp.array2d[wp.int32]  # (worlds, sheaths), evaluations without a solution


@wp.struct
class Sheath:
    """Rows of one sheath of one world."""

    world: wp.int32
    index: wp.int32  # of the sheath
    segment: wp.int32  # its first row of segments
    guide: wp.int32  # and of guides
    guides: wp.int32  # number of guides
    given: wp.bool  # whether the tension of the first segment is given


@wp.func
def sheath_at(t: Tendons, index: int, world: int) -> Sheath:
    """Rows of a sheath in a world."""
    s = Sheath()
    s.world = world
    s.index = index
    s.segment = t.first_segment[index]
    s.guide = t.first_guide[index]
    s.guides = t.guides[index]
    s.given = t.kind[index] == ELASTIC
    return s


@wp.func
def reset_sheath(t: Tendons, k: int, w: int) -> None:
    """Reset what tendons of every kind have."""
    t.started[k, w] = False
    t.has_trial[k, w] = False
    t.unsolved[w, k] = 0
    t.constraint_force[k, w] = wp.float64(0.0)
    t.previous_constraint[k, w] = wp.float64(0.0)
    t.solved_force[k, w] = wp.float64(0.0)
    for guide in range(t.first_guide[k], t.first_guide[k] + t.guides[k]):
        t.sliding_speed[guide, w] = wp.float64(0.0)


@wp.func
def follow_speed(t: Tendons, k: int, guide: int, speed: wp.float64, h: wp.float64, w: int) -> None:
    """Let the speed that Stribeck friction sees, if there is any, follow that of an ended step."""
    seen = t.sliding_speed[guide, w]
    if t.stribeck_friction[w, k] > 0.0:
        t.sliding_speed[guide, w] = seen + h / (_MEMORY + h) * (wp.abs(speed) - seen)
    elif seen != wp.float64(0.0):
        t.sliding_speed[guide, w] = wp.float64(0.0)


@wp.func
def held(
    t: Tendons, s: Sheath, j: int, tau: wp.float64
) -> tuple[wp.float64, wp.float64, wp.float64]:
    """Unstretched length s_j(τ) [m], its slope ds/dτ < 0, and 1/(1+τ)."""
    row, w = s.segment + j, s.world
    inverse = wp.float64(1.0) / (wp.float64(1.0) + tau)
    length = (t.length[row, w] - t.give[row, w] * tau) * inverse
    return length, -(t.give[row, w] + length) * inverse, inverse


@wp.func
def yielded(t: Tendons, row: int, tau: wp.float64, w: int) -> wp.float64:
    """Unstretched length that the guides beside a segment yield at a tension [m]."""
    return t.give[row, w] * tau / (ONE + tau)


@wp.func
def unstretched(t: Tendons, k: int, w: int, length: wp.float64) -> wp.float64:
    """Unstretched length of tendon that has a ``length`` under its pretension [m]."""
    return length / (ONE + t.laid_pretension[k, w] / wp.float64(t.axial_stiffness[w, k]))


@wp.func
def set_alone(t: Tendons, row: int, w: int) -> None:
    """Set the τ that a segment has at its length s: 0 when slack, inf if nothing can yield."""
    softness = t.kept[row, w] + t.give[row, w]
    tau = wp.float64(wp.inf)
    if softness > wp.float64(0.0):
        tau = wp.max(wp.float64(0.0), (t.length[row, w] - t.kept[row, w]) / softness)
    t.alone[row, w] = tau


@wp.func
def capstan(t: Tendons, guide: int, k: int, w: int) -> tuple[wp.float64, wp.float64, wp.float64]:
    """Largest ratio of tensions at a guide while it slides, and at rest; its F_c [N]."""
    sliding = wp.float64(t.friction[w, k])
    static = wp.max(sliding, wp.float64(t.static_friction[w, k]))
    scale = wp.float64(t.stribeck_velocity[w, k])
    if t.stribeck_friction[w, k] > 0.0 and scale > wp.float64(0.0):
        more = wp.float64(t.stribeck_friction[w, k]) * wp.exp(-t.sliding_speed[guide, w] / scale)
        sliding += more
        static += more
    bend, constant = wp.float64(t.angle[guide, w]), wp.float64(0.0)
    if not t.is_on_arc[guide, w]:
        bend = wp.max(wp.float64(0.0), bend + wp.float64(t.extra_bend[w, k]) / t.sharing[k])
        constant = wp.float64(t.constant_friction[w, k]) / t.sharing[k]
    dynamic = wp.exp(wp.min(sliding * bend, _HOLDS_ANYTHING))
    highest = wp.float64(dynamic)
    if static != sliding:
        highest = wp.exp(wp.min(static * bend, _HOLDS_ANYTHING))
    return dynamic, highest, constant


@wp.func
def set_guide(
    t: Tendons, row: int, w: int, dynamic: wp.float64, static: wp.float64, constant: wp.float64
) -> None:
    """Set the ratios that a guide can hold, which slides as it did in the last step."""
    slip = int(t.previous_slip[row, w])
    one = wp.float64(1.0)
    ahead, back = wp.where(slip > 0, dynamic, static), wp.where(slip < 0, dynamic, static)
    t.dynamic_ratio[row, w] = dynamic
    t.input_ratio[row, w] = ahead
    t.input_inverse[row, w] = one / ahead
    t.output_ratio[row, w] = back
    t.output_inverse[row, w] = one / back
    t.constant[row, w] = constant
    t.slip[row, w] = wp.where(constant == wp.float64(0.0) and static == one, 1, slip)
