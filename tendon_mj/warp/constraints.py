"""Constraints that friction knows, as `tendon_mj.plugin.sheath_plugin.constraints` explains."""

import mujoco
import warp as wp

from tendon_mj.warp.groups import Groups
from tendon_mj.warp.tendons import ZERO

wp.set_module_options({"enable_backward": False})

_KINDS = mujoco.mjtConstraint
_EQUALITY = wp.constant(int(_KINDS.mjCNSTR_EQUALITY))
_JOINT_LIMIT = wp.constant(int(_KINDS.mjCNSTR_LIMIT_JOINT))
_TENDON_LIMIT = wp.constant(int(_KINDS.mjCNSTR_LIMIT_TENDON))
_FRICTIONLESS = wp.constant(int(_KINDS.mjCNSTR_CONTACT_FRICTIONLESS))
_PYRAMIDAL = wp.constant(int(_KINDS.mjCNSTR_CONTACT_PYRAMIDAL))


@wp.struct
class Constraints:
    """Rows of the constraints of all worlds."""

    dof_parentid: wp.array[wp.int32]
    is_sparse: wp.bool
    nefc: wp.array[wp.int32]
    type: wp.array2d[wp.int32]
    J: wp.array3d[wp.float32]
    J_rownnz: wp.array2d[wp.int32]
    J_rowadr: wp.array2d[wp.int32]
    J_colind: wp.array3d[wp.int32]
    D: wp.array2d[wp.float32]
    aref: wp.array2d[wp.float32]
    force: wp.array2d[wp.float32]


@wp.func
def rows_of(c: Constraints, w: int) -> int:
    """Number of rows; there are fewer than constraints where the room for these is used up."""
    return wp.min(c.nefc[w], c.type.shape[1])


@wp.func
def is_equality(c: Constraints, row: int, w: int) -> bool:
    """Return whether a row pulls and pushes."""
    return c.type[w, row] == _EQUALITY


@wp.func
def read_known(c: Constraints, y: Groups, row: int, w: int) -> bool:
    """Set the moment of a row; return whether friction knows such a row."""
    kind = c.type[w, row]
    pushes = kind == _JOINT_LIMIT or kind == _TENDON_LIMIT
    pushes = pushes or kind == _FRICTIONLESS or kind == _PYRAMIDAL
    if not (pushes or kind == _EQUALITY):
        return False
    dofs = y.moment.shape[0]
    for i in range(dofs):
        y.moment[i, w] = ZERO
        if not c.is_sparse:
            y.moment[i, w] = wp.float64(c.J[w, row, i])
    if c.is_sparse:
        start = c.J_rowadr[w, row]
        for a in range(start, start + c.J_rownnz[w, row]):
            y.moment[c.J_colind[w, 0, a], w] = wp.float64(c.J[w, 0, a])
    k, moved = int(-1), int(0)
    for i in range(dofs):
        if y.moment[i, w] != ZERO:
            k, moved = i, moved + 1
    while k >= 0:  # whether all that it moves lies on one way to the world
        if y.moment[k, w] != ZERO:
            moved -= 1
        k = c.dof_parentid[k]
    return moved == 0


@wp.func
def pushes_at(y: Groups, wanted: wp.float64, acceleration: wp.array2d[wp.float64], w: int) -> bool:
    """Return whether a row that pushes, whose moment is at hand, does so at an acceleration."""
    along = wp.float64(0.0)
    for i in range(y.moment.shape[0]):
        along += y.moment[i, w] * acceleration[i, w]
    return wanted > along


@wp.func
def push_otherwise(c: Constraints, y: Groups, w: int) -> bool:
    """Return whether other constraints push at the acceleration that came out than were taken."""
    otherwise = bool(False)
    for row in range(rows_of(c, w)):
        if not is_equality(c, row, w):
            if read_known(c, y, row, w):
                wanted = wp.float64(c.aref[w, row])
                pushed = pushes_at(y, wanted, y.expected, w)
                otherwise = otherwise or pushed != pushes_at(y, wanted, y.acceleration, w)
    return otherwise


@wp.kernel
def keep_constraints(c: Constraints, y: Groups) -> None:
    """Keep the forces of the constraints that friction knew; threads (worlds,)."""
    w = wp.tid()
    for row in range(rows_of(c, w)):
        force = wp.float64(c.force[w, row])
        if force != ZERO:
            if read_known(c, y, row, w):
                for i in range(y.moment.shape[0]):
                    y.borne[i, w] = y.borne[i, w] + force * y.moment[i, w]
