"""Friction for the tendons of an MJCF file: what each bends by, what drives it, what it got."""

from __future__ import annotations

import math
import warnings
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import Literal, NamedTuple

import mujoco
import numpy as np

from tendon_mj.attach.elasticity import constraints_on, has_spring, own_elasticity
from tendon_mj.attach.friction import add_friction
from tendon_mj.attach.idlers import Idler, idlers
from tendon_mj.attach.sheath_design import idle_reason
from tendon_mj.attach.sheathed import actuators_by_tendon, force_on_tendon, sheaths_by_tendon
from tendon_mj.attach.stiffness_limit import Pull, stiffness_limits, worst_pull
from tendon_mj.attach.tendon_bend import (
    bend_at,
    extreme_poses,
    leading_joints,
    sampled_poses,
    unswept_joints,
)
from tendon_mj.attach.tendon_choice import choose_tendons
from tendon_mj.attach.tendon_path import crossed_joints, end_sites, path_of
from tendon_mj.attach.write import write_sheaths
from tendon_mj.errors import TendonError, TendonWarning
from tendon_mj.typing import FloatArray

_LOOPS = (mujoco.mjtEq.mjEQ_CONNECT.value, mujoco.mjtEq.mjEQ_WELD.value)
_UNRANGED = (
    "no ctrlrange or forcerange keeps {} from pushing, which no cable can: a force above 0 passes "
    "the sheath without friction; give a ctrlrange in which the actuator only pulls"
)


class Row(NamedTuple):
    """A tendon after friction was added to a model.

    Attributes:
        tendon: its name.
        bend: total at `qpos0`, with what is not drawn [rad].
        least_bend, most_bend: over poses that the joints allow, see `sampled_poses` and
            `extreme_poses` [rad].
        slid_bend, most_slid_bend: the same over guides that do not turn with the tendon [rad].
        idlers: sentences of those that do.
        friction: μ.
        axial_stiffness: EA [N]; None without a sheath, or as stiff as the step resolves.
        largest_stiffness: that a step carries [N].
        input: its input end, in words; empty without a sheath.
        drives: what pulls it, in words.
        pull: how stiff that is, and how stiff a step carries.
        done: what was done to it, in words.
        sheath: its name, empty without one.
        acts: whether friction can do anything.
    """

    tendon: str
    bend: float
    least_bend: float
    most_bend: float
    slid_bend: float
    most_slid_bend: float
    idlers: tuple[str, ...]
    friction: float
    axial_stiffness: float | None
    largest_stiffness: float
    input: str
    drives: str
    pull: Pull
    done: str
    sheath: str
    acts: bool

    @property
    def is_too_stiff(self) -> bool:
        """Whether EA is more than a step carries."""
        return self.axial_stiffness is not None and self.axial_stiffness > self.largest_stiffness

    @property
    def is_pulled_too_stiffly(self) -> bool:
        """Whether friction makes more of the stiffness of what pulls than a step carries."""
        return bool(self.sheath) and self.pull.magnified > self.pull.largest

    @property
    def transmission(self) -> float:
        """e^{−μφ} at `qpos0`, T_out/T_in as it slides towards the input."""
        return math.exp(-self.friction * self.slid_bend)

    @property
    def least_transmission(self) -> float:
        """e^{−μφ} where it is most bent."""
        return math.exp(-self.friction * self.most_slid_bend)


class Attached(NamedTuple):
    """A written model.

    Attributes:
        path: of the file.
        rows: of the tendons that were asked for.
        said: what `add_friction` and `write_sheaths` warned of, and which motors may push.
        limits: of the poses in which bends were looked at, in sentences.
    """

    path: Path
    rows: tuple[Row, ...]
    said: tuple[str, ...]
    limits: tuple[str, ...]


def attach_friction(
    spec: mujoco.MjSpec,
    source: Path,
    tendon: str | Sequence[str],
    path: Path,
    *,
    friction: float,
    axial_stiffness: float | None = None,
    pretension: float | None = None,
    arc_guides: int = 1,
    inner_guides: int | None = None,
    input_end: Literal["first", "last"] = "first",
    extra_bend: float = 0.0,
) -> Attached:
    """Give tendons of a model friction, and write the model as a new file.

    Args:
        spec: the model, as read from ``source``; it is changed.
        source: its MJCF file.
        tendon: as for `add_friction`, as are all the others.
        path: file to write.
        friction: μ.
        axial_stiffness: EA [N].
        pretension: T_0 [N].
        arc_guides: guides on each geom that a tendon may wrap around.
        inner_guides: guides at the input end, for ``extra_bend``.
        input_end: site at which the tendons are pulled, ``first`` or ``last``.
        extra_bend: bend that the drawn path does not show [rad].

    Raises:
        TendonError: what `add_friction` or MuJoCo refuse, or a file that cannot be written as
            asked.
    """
    try:
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            before = spec.compile()
            asked = choose_tendons(spec, tendon)
            unnamed = {one.name for one in asked if not one.element.name}
            had_spring = {one.name for one in asked if has_spring(one.element)}
            sheathed = set(sheaths_by_tendon(spec))
            add_friction(
                spec,
                tendon,
                friction=friction,
                axial_stiffness=axial_stiffness,
                pretension=pretension,
                arc_guides=arc_guides,
                inner_guides=inner_guides,
                input_end=input_end,
                extra_bend=extra_bend,
            )
            write_sheaths(source, spec, path)
    except TendonError:
        raise
    except ValueError as error:  # MuJoCo's
        raise TendonError(f"{source}: {error}") from error
    pulling, sheaths = actuators_by_tendon(spec), sheaths_by_tendon(spec)
    after, ids = spec.compile(), [one.element.id for one in asked]
    crossed = [
        {joint.id for joint in crossed_joints(one.element)}
        if path_of(one.element).is_spatial
        else set()
        for one in asked
    ]
    rolling = [idler for idler in idlers(before) if idler.tendon in ids]
    wheels = {idler.geom for idler in rolling}
    poses = _poses(before, ids, crossed, wheels)
    bends = _bends(before, ids, poses)
    slid = _bends(before, ids, poses, wheels) if rolling else bends
    rows, unranged = [], []
    for k, (one, limit) in enumerate(zip(asked, stiffness_limits(before, ids), strict=True)):
        name = one.name
        sheath = sheaths.get(name)
        config = sheath.config if sheath else {}
        more = float(config.get("extra_bend", extra_bend if not sheath else 0.0))
        bend, slid_bend = (np.maximum(b[:, k] + more, 0.0) for b in (bends, slid))
        mu = float(config.get("friction", friction))
        at = [0, int(np.argmax(slid_bend))]
        stiffness = config.get("axial_stiffness")
        moved = config.get("spring") == "cable"
        if moved and not stiffness:
            stiffness = own_elasticity(one.element, name, lambda: after)[0]
        is_driven = not moved and "pretension" not in config
        on_it = pulling.get(name, [])
        if sheath and is_driven:
            motors = [a for a in on_it if force_on_tendon(a, one.element) is None]
            unranged += [f"{a.name or f'actuator {a.id}'} on {name}" for a in motors]
        idle = idle_reason(
            one.element,
            config,
            is_driven=is_driven,
            is_wound_in="reel_joint" in config or any(a.plugin.active for a in on_it),
        )
        rows.append(
            Row(
                tendon=name,
                bend=float(bend[0]),
                least_bend=float(bend.min()),
                most_bend=float(bend.max()),
                slid_bend=float(slid_bend[0]),
                most_slid_bend=float(slid_bend.max()),
                idlers=tuple(
                    _idler(before, idler, name, 1.0 - np.exp(-mu * (bend - slid_bend).max()))
                    for idler in rolling
                    if idler.tendon == ids[k] and mu > 0.0
                ),
                friction=mu,
                axial_stiffness=float(stiffness) if stiffness else None,
                largest_stiffness=limit,
                input=_input(one.element, config) if sheath else "",
                drives=", ".join(a.name or f"actuator {a.id}" for a in on_it)
                or ("its spring" if name in had_spring else "")
                or str(constraints_on(spec, one.element))
                or "nothing",
                pull=(
                    worst_pull(after, ids[k], poses[at], np.exp(-mu * slid_bend[at]))
                    if is_driven
                    else Pull(0.0, 0.0, math.inf)
                ),
                done=_done(sheath, name in sheathed, name in unnamed, moved),
                sheath=sheath.name if sheath else "",
                acts=bool(sheath) and not idle,
            )
        )
    said = [str(w.message) for w in caught if issubclass(w.category, TendonWarning)]
    if unranged:  # no warning, as it is the usual motor, right as long as its commands pull
        said.append(_UNRANGED.format(", ".join(unranged)))
    return Attached(
        path,
        tuple(rows),
        tuple(one.removeprefix("add_friction: ") for one in said),
        _limits(before, set().union(*crossed)),
    )


def _input(tendon: mujoco.MjsTendon, config: Mapping[str, str]) -> str:
    """The input end of a tendon in a sheath: which of its ends, and the name of the site."""
    branches, end = end_sites(tendon), config.get("input_end", "first")
    return f"{end}, {branches[0][0] if end == 'first' else branches[-1][1]}"


def _done(sheath: mujoco.MjsPlugin | None, was_there: bool, unnamed: bool, moved: bool) -> str:
    if sheath is None:
        return "left as it was"
    if was_there:
        return f"left in sheath {sheath.name!r}"
    named = "named, " if unnamed else ""
    return f"{named}sheath {sheath.name!r}{', its spring as elasticity' if moved else ''}"


def _idler(model: mujoco.MjModel, idler: Idler, tendon: str, most: float) -> str:
    """Sentence of a guide that turns with its tendon, and of what is lost there."""
    radius, dof = model.geom_size[idler.geom, 0], model.jnt_dofadr[idler.joint]
    dry, damping = model.dof_frictionloss[dof] / radius, model.dof_damping[dof] / radius**2
    return (
        f"{tendon} does not slip over geom {model.geom(idler.geom).name!r}, which turns with it on "
        f"joint {model.joint(idler.joint).name!r}: it loses the bearing's torque over the radius "
        f"there, {dry:.3g} N and {damping:.3g} N s/m, where that is less than {most:.0%} of its "
        "tension"
    )


def _bends(
    model: mujoco.MjModel, tendons: list[int], poses: FloatArray, without: Collection[int] = ()
) -> FloatArray:
    """(p, tendons) bend in each pose [rad]."""
    data = mujoco.MjData(model)
    return np.array([bend_at(model, data, qpos, tendons, without) for qpos in poses])


def _poses(
    model: mujoco.MjModel, tendons: list[int], crossed: list[set[int]], wheels: set[int]
) -> FloatArray:
    """Sampled poses, and those in which each tendon bends most and least, also without wheels."""
    poses = sampled_poses(model)
    found = [poses]
    for without in [set(), wheels] if wheels else [set()]:
        columns = _bends(model, tendons, poses, without).T
        for tendon, joints, bends in zip(tendons, crossed, columns, strict=True):
            found.append(extreme_poses(model, tendon, joints, poses, bends, without))
    return np.concatenate(found)


def _limits(model: mujoco.MjModel, crossed: set[int]) -> tuple[str, ...]:
    """Joints that are not swept, though a tendon crosses them, and loops that are torn."""
    held = [
        model.joint(joint).name or f"joint {joint}"
        for joint in sorted(leading_joints(model, crossed).intersection(unswept_joints(model)))
    ]
    sentences = [f"held as in qpos0, as they have no range: {', '.join(held)}"] if held else []
    if (np.isin(model.eq_type, _LOOPS) & (model.eq_active0 != 0)).any():
        sentences.append("the poses do not keep connect and weld constraints: bends may be less")
    return tuple(sentences)
