"""Friction for the tendons of an MJCF file, and a report of each: bend, drive, sheath."""

from __future__ import annotations

import math
import warnings
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import Literal, NamedTuple

import mujoco
import numpy as np

from tendon_mj.attach.friction import add_friction
from tendon_mj.attach.instances import sheaths_by_tendon
from tendon_mj.attach.mjcf import write_sheaths
from tendon_mj.attach.sheath_design import idle_reason, own_elasticity
from tendon_mj.attach.stiffness_limit import Pull, stiffness_limits, worst_pull
from tendon_mj.attach.tendon_bend import (
    Idler,
    bend_at,
    extreme_poses,
    idlers,
    leading_joints,
    sampled_poses,
    unswept_joints,
)
from tendon_mj.attach.tendons import (
    Chosen,
    actuators_by_tendon,
    choose_tendons,
    constraints_on,
    crossed_joints,
    end_sites,
    force_on_tendon,
    has_own_spring,
    path_of,
)
from tendon_mj.errors import TendonError, TendonWarning
from tendon_mj.typing import FloatArray

_LOOPS = (mujoco.mjtEq.mjEQ_CONNECT.value, mujoco.mjtEq.mjEQ_WELD.value)
_UNRANGED = (
    "no ctrlrange or forcerange keeps {} from pushing, which no cable can: a force above 0 passes "
    "the sheath without friction; give a ctrlrange in which the actuator only pulls"
)


class Row(NamedTuple):
    """A tendon after friction was added to a model.

    Poses are those that the joints allow, see `sampled_poses` and `extreme_poses`.
    """

    tendon: str
    bend: float  # total at `qpos0`, with bend that is not drawn [rad]
    least_bend: float  # over the poses [rad]
    most_bend: float
    slid_bend: float  # at `qpos0` over guides that do not turn with the tendon [rad]
    most_slid_bend: float
    idlers: tuple[str, ...]  # sentences of guides that turn with it
    friction: float  # μ
    axial_stiffness: float | None  # EA [N]; None without a sheath, or if the step decides
    largest_stiffness: float  # EA that a step carries [N]
    input: str  # its input end, in words; empty without a sheath
    drives: str  # elements that pull it, in words
    pull: Pull
    done: str  # change to it, in words
    sheath: str  # name; empty without one
    acts: bool  # whether friction can do anything
    is_driven: bool  # whether the forces along it are its input tension

    @property
    def is_too_stiff(self) -> bool:
        """Whether EA exceeds the largest stable value for the time step."""
        return self.axial_stiffness is not None and self.axial_stiffness > self.largest_stiffness

    @property
    def is_pulled_too_stiffly(self) -> bool:
        """Whether friction magnifies the stiffness of its drive to more than a step carries."""
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
    """A written model."""

    path: Path
    rows: tuple[Row, ...]  # of the tendons that were given
    said: tuple[str, ...]  # warnings, and motors that may push
    limits: tuple[str, ...]  # of the poses in which bends were compared, in sentences


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
        path: file to write.
        tendon, friction, …: as for `add_friction`.

    Raises:
        TendonError: `add_friction` or MuJoCo refuse the model, or it cannot be written.
    """
    try:
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            model = spec.compile()
            tendons = choose_tendons(spec, tendon)
            sheathed = sheaths_by_tendon(spec)
            before = [
                _Before(t, not t.element.name, has_own_spring(t.element), t.name in sheathed)
                for t in tendons
            ]
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
    crossed = [
        {joint.id for joint in crossed_joints(t.element)}
        if path_of(t.element).is_spatial
        else set()
        for t in tendons
    ]
    survey = _survey(model, [t.element.id for t in tendons], crossed)
    models = _Models(
        spec, model, spec.compile(), sheaths_by_tendon(spec), actuators_by_tendon(spec)
    )
    rows = [_row(models, survey, k, t, friction, extra_bend) for k, t in enumerate(before)]
    said = [str(w.message) for w in caught if issubclass(w.category, TendonWarning)]
    unranged = _unranged(models, rows)
    if unranged:  # no warning, as it is the usual motor, right as long as its commands pull
        said.append(_UNRANGED.format(", ".join(unranged)))
    return Attached(
        path,
        tuple(rows),
        tuple(message.removeprefix("add_friction: ") for message in said),
        _limits(model, set().union(*crossed)),
    )


class _Before(NamedTuple):
    """A tendon before friction was added."""

    tendon: Chosen
    was_unnamed: bool
    was_sprung: bool
    was_sheathed: bool


class _Models(NamedTuple):
    """A spec with friction, the model without and with it, and sheaths and actuators by tendon."""

    spec: mujoco.MjSpec
    before: mujoco.MjModel
    after: mujoco.MjModel
    sheaths: dict[str, mujoco.MjsPlugin]
    actuators: dict[str, list[mujoco.MjsActuator]]


class _Survey(NamedTuple):
    """Bends of tendons over poses."""

    poses: FloatArray  # (p, nq), the first at `qpos0`
    bends: FloatArray  # (p, tendons) [rad]
    slid: FloatArray  # the same without idlers
    idlers: list[Idler]
    limits: list[float]  # EA that a step carries, of each tendon [N]


def _survey(model: mujoco.MjModel, ids: list[int], crossed: list[set[int]]) -> _Survey:
    """Bends in sampled poses, and in those of most and least bend, also without idlers."""
    rolling = [idler for idler in idlers(model) if idler.tendon in ids]
    wheels = {idler.geom for idler in rolling}
    poses = sampled_poses(model)
    parts = [poses]
    for without in [set(), wheels] if wheels else [set()]:
        columns = _bends(model, ids, poses, without).T
        for tendon, joints, bends in zip(ids, crossed, columns, strict=True):
            parts.append(extreme_poses(model, tendon, joints, poses, bends, without))
    poses = np.concatenate(parts)
    bends = _bends(model, ids, poses)
    slid = _bends(model, ids, poses, wheels) if rolling else bends
    return _Survey(poses, bends, slid, rolling, stiffness_limits(model, ids))


def _bends(
    model: mujoco.MjModel, tendons: list[int], poses: FloatArray, without: Collection[int] = ()
) -> FloatArray:
    """(p, tendons) bend in each pose [rad]."""
    data = mujoco.MjData(model)
    return np.array([bend_at(model, data, qpos, tendons, without) for qpos in poses])


def _row(
    models: _Models, survey: _Survey, k: int, before: _Before, friction: float, extra_bend: float
) -> Row:
    """Row of the k-th tendon of a survey."""
    element, name = before.tendon.element, before.tendon.name
    sheath, actuators = models.sheaths.get(name), models.actuators.get(name, [])
    config = sheath.config if sheath else {}
    more = float(config.get("extra_bend", 0.0 if sheath else extra_bend))
    bend, slid_bend = (np.maximum(b[:, k] + more, 0.0) for b in (survey.bends, survey.slid))
    mu = float(config.get("friction", friction))
    stiffness, is_cable = config.get("axial_stiffness"), config.get("spring") == "cable"
    if is_cable and not stiffness:
        stiffness = own_elasticity(element, name, lambda: models.after)[0]
    pull, is_driven = Pull(0.0, 0.0, math.inf), not is_cable and "pretension" not in config
    if is_driven:
        at = [0, int(np.argmax(slid_bend))]
        ratios = np.exp(-mu * slid_bend[at])
        pull = worst_pull(models.after, element.id, survey.poses[at], ratios)
    wound_in = "reel_joint" in config or any(a.plugin.active for a in actuators)
    idle = idle_reason(element, config, is_driven=is_driven, is_wound_in=wound_in)
    return Row(
        tendon=name,
        bend=float(bend[0]),
        least_bend=float(bend.min()),
        most_bend=float(bend.max()),
        slid_bend=float(slid_bend[0]),
        most_slid_bend=float(slid_bend.max()),
        idlers=_idlers(models.before, survey, before.tendon, mu, float((bend - slid_bend).max())),
        friction=mu,
        axial_stiffness=float(stiffness) if stiffness else None,
        largest_stiffness=survey.limits[k],
        input=_input(element, config) if sheath else "",
        drives=_drives(models.spec, before, actuators),
        pull=pull,
        done=_done(sheath, before, is_cable),
        sheath=sheath.name if sheath else "",
        acts=bool(sheath) and not idle,
        is_driven=is_driven,
    )


def _unranged(models: _Models, rows: Sequence[Row]) -> list[str]:
    """Actuators of driven tendons that no range keeps from pushing."""
    return [
        f"{_label(actuator)} on {row.tendon}"
        for row in rows
        if row.sheath and row.is_driven
        for actuator in models.actuators.get(row.tendon, [])
        if force_on_tendon(actuator, models.spec.tendon(row.tendon)) is None
    ]


def _label(actuator: mujoco.MjsActuator) -> str:
    return actuator.name or f"actuator {actuator.id}"


def _drives(spec: mujoco.MjSpec, before: _Before, actuators: Sequence[mujoco.MjsActuator]) -> str:
    return (
        ", ".join(map(_label, actuators))
        or ("its spring" if before.was_sprung else "")
        or str(constraints_on(spec, before.tendon.element))
        or "nothing"
    )


def _input(tendon: mujoco.MjsTendon, config: Mapping[str, str]) -> str:
    """The input end of a tendon in a sheath: which of its ends, and the name of the site."""
    branches, end = end_sites(tendon), config.get("input_end", "first")
    return f"{end}, {branches[0][0] if end == 'first' else branches[-1][1]}"


def _done(sheath: mujoco.MjsPlugin | None, before: _Before, is_cable: bool) -> str:
    if sheath is None:
        return "left as it was"
    if before.was_sheathed:
        return f"left in sheath {sheath.name!r}"
    named = "named, " if before.was_unnamed else ""
    return f"{named}sheath {sheath.name!r}{', its spring as elasticity' if is_cable else ''}"


def _idlers(
    model: mujoco.MjModel, survey: _Survey, tendon: Chosen, mu: float, bend: float
) -> tuple[str, ...]:
    """Sentences of the guides that turn with a tendon, which bend it by ``bend`` at most."""
    sentences, most = [], 1.0 - math.exp(-mu * bend)
    for idler in survey.idlers if mu > 0.0 else ():
        if idler.tendon == tendon.element.id:
            radius, dof = model.geom_size[idler.geom, 0], model.jnt_dofadr[idler.joint]
            dry, damping = model.dof_frictionloss[dof] / radius, model.dof_damping[dof] / radius**2
            sentences.append(
                f"{tendon.name} does not slip over geom {model.geom(idler.geom).name!r}, which "
                f"turns with it on joint {model.joint(idler.joint).name!r}: it loses the bearing's "
                f"torque over the radius there, {dry:.3g} N and {damping:.3g} N s/m, where that is "
                f"less than {most:.0%} of its tension"
            )
    return tuple(sentences)


def _limits(model: mujoco.MjModel, crossed: set[int]) -> tuple[str, ...]:
    """Joints that are not swept, though a tendon crosses them, and loops that the poses tear."""
    held = [
        model.joint(joint).name or f"joint {joint}"
        for joint in sorted(leading_joints(model, crossed).intersection(unswept_joints(model)))
    ]
    sentences = [f"held as in qpos0, as they have no range: {', '.join(held)}"] if held else []
    if (np.isin(model.eq_type, _LOOPS) & (model.eq_active0 != 0)).any():
        sentences.append("the poses do not keep connect and weld constraints: bends may be less")
    return tuple(sentences)
