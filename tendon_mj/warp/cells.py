"""Guides of inextensible tendons that can hold or slide by themselves, as the model has them.

Guides between which no length can change make a *cell*. A stretch next to a geom is a span only
while the tendon is on one side of contact; cells that no span parts in the pose at hand make one
*group*, which its first cell stands for.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import mujoco
import numpy as np
from numpy.typing import NDArray

from tendon_mj.warp.groups import Groups
from tendon_mj.warp.support import Rows, Simulated
from tendon_mj.warp.transfer import in_each_world, inextensible_of, put, put_zeros

_PULLEY, _SITE = mujoco.mjtWrap.mjWRAP_PULLEY.value, mujoco.mjtWrap.mjWRAP_SITE.value
_TENDON = mujoco.mjtTrn.mjTRN_TENDON.value
_AFFINE = mujoco.mjtBias.mjBIAS_AFFINE.value


# rows → names of arrays with a column for each world
_BY_WORLD = {
    "cells": "before tension way way_before friction speed speed_before mobility eases missing"
    " along answer upper_ratio upper_offset lower_ratio lower_offset slid slides set_for flows"
    " is_rough head",
    "members": "active input_before input force constant damping whole",
    "D": "D",
    "entries": "input_row",
    "solved": "solved",
    "spans": "span span_solved",
    "factor": "factor",
    "dofs": "unknown last expected known borne inverse moment acceleration gradient",
}


class Cell(NamedTuple):
    """Guides of a tendon between which no length can change, in a branch of some divisor."""

    begin: int
    end: int
    parent: int  # cell, −1 for the input
    begins: bool  # whether a branch begins with it
    divisor: float


def _may_move(model: mujoco.MjModel, sheath: Simulated) -> list[bool]:
    """Return whether the length of a segment can change, for each one."""
    kinds, bodies = path_elements(model, sheath)
    moves = [False] * len(sheath.segments)
    j, k = int(sheath.state["inner_guides"]), 0
    while k < len(kinds) - 1:
        if kinds[k + 1] == _PULLEY:
            j, k = j + 1, k + 2
            continue
        if kinds[k + 1] == _SITE:
            moves[j] = bodies[k] != bodies[k + 1]
            k += 1
        else:
            near, drum, far = bodies[k : k + 3]
            moves[j] = near != drum or near != far
            j += int(sheath.state["arc_guides"])
            moves[j] = drum != far
            k += 2
        if k < len(kinds) - 1 and kinds[k + 1] != _PULLEY:
            j += 1
    return moves


def path_elements(model: mujoco.MjModel, sheath: Simulated) -> tuple[list[int], list[int]]:
    """Kinds of the elements of a path, and their bodies, from the input on; −1 for a pulley."""
    tendon = int(sheath.state["tendon"])
    path = slice(adr := int(model.tendon_adr[tendon]), adr + int(model.tendon_num[tendon]))
    kinds, bodies = model.wrap_type[path].tolist(), []
    for kind, which in zip(kinds, model.wrap_objid[path].tolist(), strict=True):
        of = model.site_bodyid if kind == _SITE else model.geom_bodyid
        bodies.append(-1 if kind == _PULLEY else int(of[which]))
    step = -1 if sheath.state["input_at_last"] else 1
    return kinds[::step], bodies[::step]


def bodies_behind(model: mujoco.MjModel) -> NDArray[np.int32]:
    """Number of the first body after those that each body carries; these follow it in a row."""
    sizes = np.ones(model.nbody, int)
    for body in range(model.nbody - 1, 0, -1):
        sizes[model.body_parentid[body]] += sizes[body]
    return (np.arange(model.nbody) + sizes).astype(np.int32)


def moved_dofs(model: mujoco.MjModel, sheath: Simulated) -> NDArray[np.bool_]:
    """(dofs,), whether a degree of freedom moves some bodies of a path and not others."""
    first = model.dof_bodyid[:, None]
    behind = bodies_behind(model)[model.dof_bodyid][:, None]
    bodies = np.array([body for body in path_elements(model, sheath)[1] if body >= 0])
    carried = (first <= bodies) & (bodies < behind)
    return carried.any(axis=1) & ~carried.all(axis=1)


def cells_of(model: mujoco.MjModel, sheath: Simulated) -> tuple[list[Cell], list[int]]:
    """Cells of a tendon, in the order of its path, and the one that owns each segment."""
    moves, guides = _may_move(model, sheath), sheath.guides
    cells: list[Cell] = []
    owners, owner, begins = [-1], -1, True
    for i in range(len(guides)):
        if guides[i]["is_pulley"]:
            fed_by = int(guides[i]["fed_by"])
            owner, begins = owners[fed_by] if 0 <= fed_by <= i else -1, True
        elif begins or moves[i]:
            divisor = float(sheath.segments[i]["divisor"])
            cells.append(Cell(i, i + 1, owner, begins, divisor))
            owner, begins = len(cells) - 1, False
        else:
            cells[-1] = cells[-1]._replace(end=i + 1)
        owners.append(owner)
    return cells, owners


def _starts(counts: Any) -> NDArray[np.int64]:
    """Where each of a row of parts begins, and the end of the last."""
    return np.concatenate([[0], np.cumsum(np.asarray(counts, int))])


def _dampers(model: mujoco.MjModel, tendons: list[int]) -> list[int]:
    """Actuators that an implicit integrator damps, and −1 − member of the tendons' own dampers.

    One that is 0 when the data are made is not among them: M̂ is then less than it might be.
    """
    damped = (model.actuator_biastype == _AFFINE) & (model.actuator_biasprm[:, 2] != 0.0)
    own = [-1 - i for i, tendon in enumerate(tendons) if model.tendon_damping[tendon] > 0.0]
    return [*np.flatnonzero(damped), *own]


def allocate_groups(
    model: mujoco.MjModel,
    simulated: dict[str, Simulated],
    at: Rows,
    nworld: int,
) -> Any:
    """Groups of all inextensible tendons, each as it is in the simulation.

    Args:
        model: with sheaths.
        simulated: each by name.
        at: rows of all sheaths.
        nworld: number of worlds.
    """
    members = inextensible_of(simulated)
    y, indices = Groups(), list(members)
    of_member = [cells_of(model, sheath) for sheath in members.values()]
    starts = _starts([len(cells) for cells, _ in of_member])
    dofs = [np.flatnonzero(moved_dofs(model, sheath)) for sheath in members.values()]
    ranges = [_range(model, each) for each in dofs]
    cells = [(i, cell) for i, (own, _) in enumerate(of_member) for cell in own]
    entry_dof = np.concatenate([*dofs, []]).astype(int)
    in_order = np.argsort(entry_dof, kind="stable")
    segments = max((at.segment[k] + len(s.segments) for k, s in members.items()), default=0)
    owner, divisor = np.full(segments, -1), np.ones(segments)
    for i, (k, sheath) in enumerate(members.items()):
        own = slice(begin := at.segment[k], begin + len(sheath.segments))
        owner[own] = [c + starts[i] if c >= 0 else -1 for c in of_member[i][1]]
        divisor[own] = sheath.segments["divisor"]
    elastic = [
        (at.segment[k] + j, moves)
        for k, sheath in enumerate(simulated.values())
        if sheath.state["driven"] and not sheath.state["inextensible"]
        for j, moves in enumerate(_may_move(model, sheath))
    ]
    moving = np.array([moves for _, moves in elastic], bool)
    rows = _starts([len(dofs[i]) for i, _ in cells])
    solved = _starts([ranges[i][1] - ranges[i][0] for i, _ in cells])
    described = {
        "sheath": indices,
        "first_cell": starts,
        "first_dof": _starts([len(each) for each in dofs]),
        "low": [low for low, _ in ranges],
        "high": [high for _, high in ranges],
        "may_spread": [bool(s.state["spreads"]) for s in members.values()],
        "dof": entry_dof,
        "dof_member": np.repeat(np.arange(len(dofs)), [len(each) for each in dofs]),
        "first_entry": np.searchsorted(entry_dof[in_order], np.arange(model.nv + 1)),
        "entry": in_order,
        "member": [i for i, _ in cells],
        "begin": [cell.begin + at.guide[indices[i]] for i, cell in cells],
        "end": [cell.end + at.guide[indices[i]] for i, cell in cells],
        "parent": [c.parent + starts[i] if c.parent >= 0 else -1 for i, c in cells],
        "begins": [cell.begins for _, cell in cells],
        "divisor": [cell.divisor for _, cell in cells],
        "row": rows[:-1],
        "solved_row": solved[:-1],
        "owner": owner,
        "segment_divisor": divisor,
        "span_segment": [row for row, _ in elastic],
        "span_row": np.where(moving, model.nv * (np.cumsum(moving) - 1), -1),
        "damper": _dampers(model, [int(s.state["tendon"]) for s in members.values()]),
    }
    described["pending"] = np.full(nworld, True)
    put(Groups, y, described)
    counts = {
        "cells": len(cells),
        "members": len(indices),
        "entries": len(entry_dof),
        "D": int(rows[-1]),
        "solved": int(solved[-1]),
        "spans": model.nv * int(moving.sum()),
        "factor": int(model.nC) if indices or elastic else 0,
        "dofs": model.nv if indices or elastic else 0,
    }
    for rows_of_each, names in _BY_WORLD.items():
        put_zeros(Groups, y, names, (counts[rows_of_each], nworld))
    _fill_state(y, simulated, of_member, nworld)
    return y


def _range(model: mujoco.MjModel, dofs: NDArray[Any]) -> tuple[int, int]:
    """First dof of the trees in which some dofs are, and the one after their last."""
    if not len(dofs):
        return 0, 0
    trees = model.dof_treeid[dofs]
    own = np.flatnonzero((model.dof_treeid >= trees.min()) & (model.dof_treeid <= trees.max()))
    return int(own[0]), int(own[-1]) + 1


_STATE = {
    "slid": "previous_slip",
    "way_before": "way",
    "speed_before": "ended",
}


def _fill_state(
    y: Any,
    simulated: dict[str, Simulated],
    of_member: list[tuple[list[Cell], list[int]]],
    nworld: int,
) -> None:
    """Give every world the committed state of the simulation."""
    sheaths = inextensible_of(simulated).values()
    columns: dict[str, list[float]] = {name: [] for name in ("before", *_STATE)}
    for sheath, (cells, _) in zip(sheaths, of_member, strict=True):
        for cell in cells:
            tension = sheath.segments["previous_tension"][cell.end]
            columns["before"].append(tension * cell.divisor)
            for name, field in _STATE.items():
                sign = -1.0 if name == "slid" else 1.0
                columns[name].append(sign * sheath.guides[field][cell.end - 1])
            if not sheath.state["slips_kept"]:
                columns["speed_before"][-1] = np.nan
    columns["unknown"] = [force for s in simulated.values() for force in s.unknown]
    columns["last"] = [each for s in simulated.values() for each in s.last]
    columns["input_before"] = [s.segments["previous_tension"][0] for s in sheaths]
    filled = {name: values for name, values in columns.items() if getattr(y, name).size}
    put(Groups, y, {name: in_each_world(values, nworld) for name, values in filled.items()})


def read_groups_back(
    model: mujoco.MjModel, simulated: dict[str, Simulated], y: Any, world: int
) -> None:
    """Write the committed state of a world, as `allocate_groups` takes it."""
    names, members = ("before", "input_before", *_STATE), inextensible_of(simulated).values()
    column = {name: getattr(y, name).numpy()[:, world] for name in names}
    for sheath in simulated.values() if members else ():
        sheath.unknown[:] = y.unknown.numpy()[: len(sheath.unknown), world]
        sheath.last[:] = y.last.numpy()[: len(sheath.last), world]
    c = 0
    for i, sheath in enumerate(members):
        cells, owners = cells_of(model, sheath)
        tensions = np.append(column["before"][c : c + len(cells)], column["input_before"][i])
        sheath.segments["previous_tension"] = tensions[owners] / sheath.segments["divisor"]
        for cell in cells:
            here = slice(cell.begin, cell.end)
            for name, field in _STATE.items():
                sheath.guides[field][here] = (-1.0 if name == "slid" else 1.0) * column[name][c]
            c += 1
        sheath.state["slips_kept"] = np.isfinite(sheath.guides["ended"]).all()
        sheath.guides["ended"] = np.nan_to_num(sheath.guides["ended"])
