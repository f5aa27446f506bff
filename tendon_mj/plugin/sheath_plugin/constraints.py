"""Constraints that friction knows: equalities, limits and contacts, the springs that MuJoCo makes.

A row of constraints with the moment r bears λ = D (a_ref − r a), an equality always, a limit or a
contact where that pushes. For friction it belongs to the response and to the forces,

    M̂ + Σ D r rᵀ,   F + Σ D a_ref r,

so that both are solved together; the force of the last step would come a step late. Which limits
and contacts push is told by the acceleration of the last step and, where others push at the one
that comes out, once more by that: friction would hold against a limit that a pull has just left.
Of rows that join two branches of the tree, for which M̂ has no place, of elliptic contacts and of
dry friction the force of the last step has to do.
"""

from __future__ import annotations

import mujoco

from tendon_mj.native import apart, compiled
from tendon_mj.plugin.abi.layout import Data, Model
from tendon_mj.plugin.abi.library import free, malloc, mj_isSparse
from tendon_mj.plugin.abi.memory import coordinates
from tendon_mj.plugin.sheath_plugin.group_solver import dot
from tendon_mj.plugin.sheath_plugin.response import add_damper
from tendon_mj.typing import FloatArray

_CONSTRAINT = mujoco.mjtConstraint
_EQUALITY = _CONSTRAINT.mjCNSTR_EQUALITY.value
_PUSH = tuple(
    kind.value
    for kind in (
        _CONSTRAINT.mjCNSTR_LIMIT_JOINT,
        _CONSTRAINT.mjCNSTR_LIMIT_TENDON,
        _CONSTRAINT.mjCNSTR_CONTACT_FRICTIONLESS,
        _CONSTRAINT.mjCNSTR_CONTACT_PYRAMIDAL,
    )
)


@compiled
def _set_moment(m: Model, d: Data, row: int, moment: FloatArray) -> None:
    """Set the moment r of a row of constraints."""
    nv, values = m.nv, d.efc_J
    if mj_isSparse(m) != 0:
        columns, start = d.efc_J_colind, d.efc_J_rowadr[row]
        for i in range(nv):
            moment[i] = 0.0
        for k in range(start, start + d.efc_J_rownnz[row]):
            moment[columns[k]] = values[k]
    else:
        for i in range(nv):
            moment[i] = values[nv * row + i]


@compiled
def _is_branch(m: Model, moment: FloatArray) -> bool:
    """Return whether all that a row moves lies on one way from a body to the world."""
    parents, k, moved = m.dof_parentid, -1, 0
    for i in range(m.nv):
        if moment[i] != 0.0:
            k, moved = i, moved + 1
    while k >= 0:
        moved -= moment[k] != 0.0
        k = parents[k]
    return moved == 0


@compiled
def _read_known(m: Model, d: Data, row: int, moment: FloatArray) -> bool:
    """Set the moment of a row; return whether friction knows such a row."""
    kind = d.efc_type[row]
    if kind != _EQUALITY and kind not in _PUSH:
        return False
    _set_moment(m, d, row, moment)
    return _is_branch(m, moment)


@apart
def add_constraints(
    m: Model, d: Data, work: int, acceleration: FloatArray, moment: FloatArray, force: FloatArray
) -> bool:
    """Add the constraints that bear to M̂ at ``work``, and set their ``force`` at no acceleration.

    Those that push are told by the ``acceleration``; ``moment`` is room for one.

    Returns:
        Whether there are constraints that push only.
    """
    nv, pushing = m.nv, False
    for i in range(nv):
        force[i] = 0.0
    for row in range(d.nefc):
        if not _read_known(m, d, row, moment):
            continue
        wanted, stiffness = d.efc_aref[row], d.efc_D[row]
        is_equality = d.efc_type[row] == _EQUALITY
        pushing |= not is_equality
        if is_equality or wanted > dot(moment, acceleration, nv):
            add_damper(m, work, moment, stiffness / m.opt.timestep)
            for i in range(nv):
                force[i] += stiffness * wanted * moment[i]
    return pushing


@apart
def push_otherwise(
    m: Model, d: Data, before: FloatArray, acceleration: FloatArray, moment: FloatArray
) -> bool:
    """Return whether other constraints push at an acceleration than at that ``before``."""
    nv, otherwise = m.nv, False
    for row in range(d.nefc):
        if d.efc_type[row] in _PUSH and _read_known(m, d, row, moment):
            wanted = d.efc_aref[row]
            pushed = wanted > dot(moment, before, nv)
            otherwise |= pushed != (wanted > dot(moment, acceleration, nv))
    return otherwise


@apart
def take_constraints_out(m: Model, d: Data, force: FloatArray) -> None:
    """Take the forces that friction knew beforehand out of those of a step that ends."""
    nv = m.nv
    place = malloc(8 * nv)
    moment = coordinates(place)
    for row in range(d.nefc):
        if d.efc_force[row] != 0.0 and _read_known(m, d, row, moment):
            for i in range(nv):
                force[i] -= d.efc_force[row] * moment[i]
    free(place)
