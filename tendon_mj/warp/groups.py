"""Groups of guides of all inextensible tendons of all worlds, as arrays on the device."""

import warp as wp

wp.set_module_options({"enable_backward": False})


@wp.struct
class Groups:
    """State and work space of all inextensible tendons; (cells, worlds) without another note.

    Tensions and lengths are in double precision; speeds, accelerations, bounds, and the rows of D
    and of M̂⁻¹ Dᵀ in single precision, as are the velocities and the inertia that they follow from.
    Those of D have an entry for each dof that moves the path of the sheath, those of M̂⁻¹ Dᵀ for
    each dof of the trees in which these are.
    """

    # description of the sheaths, (members,)
    sheath: wp.array[wp.int32]  # index among all
    first_cell: wp.array[wp.int32]  # (members + 1,)
    first_dof: wp.array[wp.int32]  # (members + 1,), in ``dof``
    low: wp.array[wp.int32]  # first dof of its trees
    high: wp.array[wp.int32]  # the one after their last
    may_spread: wp.array[wp.bool]  # whether a limit or an equality can hold its length
    # of the dofs that move their paths, (entries,)
    dof: wp.array[wp.int32]
    dof_member: wp.array[wp.int32]
    first_entry: wp.array[wp.int32]  # (dofs + 1,), of a dof in ``entry``
    entry: wp.array[wp.int32]
    # of the cells, (cells,)
    member: wp.array[wp.int32]
    begin: wp.array[wp.int32]  # row of the first guide
    end: wp.array[wp.int32]  # row after that of the last one
    parent: wp.array[wp.int32]  # cell whose tension comes in, −1: the input's
    begins: wp.array[wp.bool]  # whether a branch begins with it
    divisor: wp.array[wp.float64]
    row: wp.array[wp.int32]  # first row of D
    solved_row: wp.array[wp.int32]  # first row of M̂⁻¹ Dᵀ
    # of the segments of all sheaths, (segments,)
    owner: wp.array[wp.int32]  # cell whose tension it has, −1: the input's
    segment_divisor: wp.array[wp.float64]
    # of the segments of driven elastic tendons, (elastic segments,)
    span_segment: wp.array[wp.int32]  # row among all segments
    span_row: wp.array[wp.int32]  # first row of J, −1 where nothing moves it
    # dampers that are integrated implicitly: actuators; −1 − member: the tendon's own
    damper: wp.array[wp.int32]
    # committed state
    before: wp.array2d[wp.float64]  # T behind the cell, times its divisor [N]
    slid: wp.array2d[wp.int8]  # direction of the slip: +1 to the output, −1, 0 at rest
    way_before: wp.array2d[wp.float64]  # L, length to the output end [m]
    speed_before: wp.array2d[wp.float32]  # D q̇ with D of the step before [m/s]; NaN: none is known
    input_before: wp.array2d[wp.float64]  # (members, worlds), T_0 [N]
    unknown: wp.array2d[wp.float64]  # (dofs, worlds), r, forces that friction did not know
    last: wp.array2d[wp.float64]  # (dofs, worlds), acceleration of the last step
    # of the step on trial
    pending: wp.array[wp.bool]  # (worlds,), whether it is to be solved
    expected: wp.array2d[wp.float64]  # (dofs, worlds), acceleration that tells what pushes
    known: wp.array2d[wp.float64]  # (dofs, worlds), forces that it knows, and its own
    borne: wp.array2d[wp.float64]  # (dofs, worlds), forces of constraints that it knew beforehand
    tension: wp.array2d[wp.float64]  # T behind the cell, times its divisor [N]
    slides: wp.array2d[wp.int8]  # +1 at the upper bound, −1 at the lower one, 0 if it holds
    flows: wp.array2d[wp.bool]  # whether tendon passes there in that direction
    input: wp.array2d[wp.float64]  # (members, worlds), T_0 [N]
    # groups, in the rows of their first cells
    head: wp.array2d[wp.int32]  # first cell of a cell's group
    is_rough: wp.array2d[wp.bool]  # whether there is friction; False for other cells
    way: wp.array2d[wp.float64]  # L, length from there to the output end [m]
    speed: wp.array2d[wp.float32]  # D q̇ of the slip, and that of bodies without a velocity [m/s]
    missing: wp.array2d[wp.float32]  # by how much it has still to be slowed [m/s²]
    along: wp.array2d[wp.float32]  # change of friction along the conjugate gradient [N]
    answer: wp.array2d[wp.float32]  # D M̂⁻¹ Dᵀ of that [m/s²]
    mobility: wp.array2d[wp.float32]  # D M̂⁻¹ Dᵀ [1/kg]
    eases: wp.array2d[wp.float32]  # how much less T_0 is for each newton of friction
    friction: wp.array2d[wp.float64]  # f [N]
    upper_ratio: wp.array2d[wp.float32]  # T ≤ upper_ratio T_in + upper_offset
    upper_offset: wp.array2d[wp.float32]  # [N]
    lower_ratio: wp.array2d[wp.float32]  # T ≥ (T_in − lower_offset) / lower_ratio
    lower_offset: wp.array2d[wp.float32]  # [N]
    set_for: wp.array2d[wp.int8]  # ``slides`` for which these bounds are
    # sheaths, (members, worlds)
    active: wp.array2d[wp.bool]  # whether there is a force to solve for
    force: wp.array2d[wp.float64]  # along the tendon, negative pulls [N]
    constant: wp.array2d[wp.float64]  # what it would be without friction and acceleration [N]
    damping: wp.array2d[wp.float64]  # k of its implicit damping [N s/m]
    whole: wp.array2d[wp.float64]  # L_0 where the stretch is spread along the tendon, else inf [m]
    # rows
    D: wp.array2d[wp.float32]
    input_row: wp.array2d[wp.float32]  # (entries, worlds), D_0
    solved: wp.array2d[wp.float32]
    span: wp.array2d[wp.float32]  # J, an entry for each dof
    span_solved: wp.array2d[wp.float32]  # M̂⁻¹ Jᵀ
    factor: wp.array2d[wp.float64]  # (numbers of M, worlds)
    inverse: wp.array2d[wp.float64]  # (dofs, worlds)
    acceleration: wp.array2d[wp.float64]  # (dofs, worlds)
    moment: wp.array2d[wp.float64]  # (dofs, worlds), of one damper or constraint
    gradient: wp.array2d[wp.float64]  # (dofs, worlds), M̂⁻¹ Dᵀ of changes along the gradient
