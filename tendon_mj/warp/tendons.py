"""All sheathed tendons of all worlds at one moment, as arrays on the device; law of a segment.

A tendon's n+1 segments lie in a row, and so do its n guides; guide i sits between segments i and
i+1. Rows come first and worlds second, so that threads of neighbouring worlds read neighbouring
numbers. As in `tendon_mj.sheath` tensions are normalised, τ = T/EA, and a segment of a purely
elastic tendon holds the unstretched length

    s(τ) = (ℓ − g τ) / (1 + τ).

Lengths, tensions and flows are in double precision: the strain of a tendon is a difference of
lengths, of 1e-4 and less, which single precision would round by a thousandth.
"""

import warp as wp

wp.set_module_options({"enable_backward": False})


@wp.struct
class Tendons:
    """State and work space of the sheaths; (segments, worlds), (guides, worlds) and so on."""

    # description of each sheath, (sheaths,); −1: none
    tendon: wp.array[wp.int32]
    first_segment: wp.array[wp.int32]
    first_guide: wp.array[wp.int32]
    guides: wp.array[wp.int32]
    first_arc: wp.array[wp.int32]
    arc_guides: wp.array[wp.int32]
    inner_guides: wp.array[wp.int32]
    sharing: wp.array[wp.float64]  # number of guides that share F_c and φ_x
    step: wp.array[wp.int32]  # +1 where the path is followed as it is drawn, −1: from its last site
    driven: wp.array[wp.bool]
    constrained: wp.array[wp.bool]  # driven, and by equalities or a limit as well
    own_spring: wp.array[wp.bool]  # whether the tendon's own spring is the cable's elasticity
    beyond_spring: wp.array[wp.float64]  # unstretched length less the rest length of that [m]
    reel: wp.array[wp.int32]  # address of its control
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
    # committed state
    started: wp.array2d[wp.bool]  # (sheaths, worlds), whether the tendon has been laid
    stored: wp.array2d[wp.float64]  # s, unstretched length in a segment [m]
    before: wp.array2d[wp.float64]  # τ after the step before
    previous_slip: wp.array2d[wp.int32]  # of a guide: +1 to the input, −1, 0 at rest
    wound_in: wp.array2d[wp.float64]  # (sheaths, worlds) [m]
    wound_out: wp.array2d[wp.float64]
    spring_length: wp.array2d[wp.float64]  # rest length S of the tendon's own spring [m]
    spring_product: wp.array2d[wp.float64]  # k S of it [N]
    constraint_force: wp.array2d[wp.float64]  # λ of equalities and limits, negative pulls [N]
    touched: wp.array2d[wp.bool]  # (arcs, worlds), whether the tendon lay on the geom
    near_tangent: wp.array2d[wp.vec3d]  # in the frame of the geom [m]
    far_tangent: wp.array2d[wp.vec3d]
    # of the step on trial, which the next one commits
    has_trial: wp.array2d[wp.bool]  # (sheaths, worlds)
    trial_time: wp.array2d[wp.float32]  # [s]
    trial_wound_in: wp.array2d[wp.float64]
    trial_wound_out: wp.array2d[wp.float64]
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
    point: wp.array2d[wp.int32]  # of MuJoCo's path, where a segment's span begins; −1 without one
    near_body: wp.array2d[wp.int32]
    far_body: wp.array2d[wp.int32]
    # work space of the solver
    breakpoint: wp.array2d[wp.float64]  # (2 guides, worlds), τ before the map of its stack
    bend: wp.array2d[wp.float64]  # slope of G_j beyond it less slope before it [m]
    jump: wp.array2d[wp.float64]  # G_j beyond it less G_j before it [m]
    kept: wp.array2d[wp.float64]  # s before the flow of this step, after winding and shifts
    prefix: wp.array2d[wp.float64]  # τ* of the tendon cut behind a segment
    static_ratio: wp.array2d[wp.float64]  # e^{μ_s φ}
    dynamic_ratio: wp.array2d[wp.float64]  # e^{μ_d φ}
    input_ratio: wp.array2d[wp.float64]  # largest τ_i/τ_{i+1} that holds now
    output_ratio: wp.array2d[wp.float64]  # largest τ_{i+1}/τ_i
    constant: wp.array2d[wp.float64]  # F_c of a guide over EA
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
    s.given = t.driven[index]
    return s


@wp.func
def held(t: Tendons, s: Sheath, j: int, tau: wp.float64) -> tuple[wp.float64, wp.float64]:
    """Unstretched length s_j(τ) [m] and its slope ds/dτ < 0."""
    row, w = s.segment + j, s.world
    inverse = wp.float64(1.0) / (wp.float64(1.0) + tau)
    length = (t.length[row, w] - t.give[row, w] * tau) * inverse
    return length, -(t.give[row, w] + length) * inverse


@wp.func
def tension_of(t: Tendons, s: Sheath, j: int) -> wp.float64:
    """τ of a segment at its present length s; 0 when slack, inf where nothing can yield."""
    row, w = s.segment + j, s.world
    softness = t.kept[row, w] + t.give[row, w]
    if softness <= wp.float64(0.0):
        return wp.float64(wp.inf)
    return wp.max(wp.float64(0.0), (t.length[row, w] - t.kept[row, w]) / softness)
