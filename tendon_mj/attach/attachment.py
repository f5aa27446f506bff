"""Friction for the tendons of an MJCF file, and a report of each: bend, drive, sheath."""

from __future__ import annotations

import math
import warnings
from collections.abc import Collection, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

import mujoco
import numpy as np

from tendon_mj.attach import tendon_bend, tendons
from tendon_mj.attach.friction import add_friction
from tendon_mj.attach.instances import sheaths_by_tendon
from tendon_mj.attach.mjcf import write_sheaths
from tendon_mj.attach.sheath_design import idle_reason, own_elasticity
from tendon_mj.attach.stiffness_limit import stiffness_limits
from tendon_mj.errors import TendonError, TendonWarning
from tendon_mj.typing import FloatArray

_LOOP_EQUALITIES = (mujoco.mjtEq.mjEQ_CONNECT.value, mujoco.mjtEq.mjEQ_WELD.value)
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
    done: str  # change to it, in words
    sheath: str  # name; empty without one
    acts: bool  # whether friction can do anything
    is_driven: bool  # whether the forces along it are its input tension
    has_pulleys: bool  # whether the bends are those of its most bent branch

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


@contextmanager
def changing(source: Path, caller: str) -> Iterator[list[str]]:
    """Change the spec of a file: a list that has the warnings of a function afterwards.

    Raises:
        TendonError: MuJoCo refuses the model; the message has the file's name.
    """
    said: list[str] = []
    try:
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            yield said
    except TendonError:
        raise
    except ValueError as error:  # MuJoCo's
        raise TendonError(f"{source}: {error}") from error
    ours = (str(w.message) for w in caught if issubclass(w.category, TendonWarning))
    said += (message.removeprefix(f"{caller}: ") for message in ours)


def attach_friction(
    spec: mujoco.MjSpec, source: Path, tendon: str | Sequence[str], path: Path, **options: Any
) -> Attached:
    """Give tendons of a model friction, and write the model as a new file.

    ``spec`` was read from ``source``, and is changed; ``options`` are those of `add_friction`
    except ``reel`` and ``spool``. Raises `TendonError` where it or MuJoCo refuse the model, or the
    file cannot be written.
    """
    with changing(source, "add_friction") as said:
        model, chosen = spec.compile(), tendons.choose_tendons(spec, tendon)
        earlier = sheaths_by_tendon(spec)
        named = {t.name for t in chosen if not t.element.name}
        add_friction(spec, tendon, **options)
        write_sheaths(source, spec, path)
    crossed = [
        {joint.id for joint in tendons.crossed_joints(t.element)}
        if tendons.path_of(t.element).is_spatial
        else set()
        for t in chosen
    ]
    survey = _survey(spec, model, [t.element.id for t in chosen], crossed)
    bend = options.get("extra_bend", 0.0)
    rows = [
        _tendon_row(survey, k, t, _done(survey, t.name, named, earlier), options["friction"], bend)
        for k, t in enumerate(chosen)
    ]
    unranged = _unranged(survey, rows)
    if unranged:  # no warning, as it is the usual motor, right as long as its commands pull
        said.append(_UNRANGED.format(", ".join(unranged)))
    return Attached(path, tuple(rows), tuple(said), _limits(model, set().union(*crossed)))


class _Survey(NamedTuple):
    """A spec with friction, the model without and with it, and bends of tendons over poses."""

    spec: mujoco.MjSpec
    before: mujoco.MjModel
    after: mujoco.MjModel
    sheaths: dict[str, mujoco.MjsPlugin]
    actuators: dict[str, list[mujoco.MjsActuator]]
    poses: FloatArray  # (p, nq), the first at `qpos0`
    bends: FloatArray  # (p, tendons) [rad]
    slid: FloatArray  # the same without idlers
    idlers: list[tendon_bend.Idler]
    limits: list[float]  # EA that a step carries, of each tendon [N]


def _survey(
    spec: mujoco.MjSpec, model: mujoco.MjModel, ids: list[int], crossed: list[set[int]]
) -> _Survey:
    """Bends in sampled poses, and in those of most and least bend, also without idlers."""
    data = mujoco.MjData(model)

    def bends_in(poses: FloatArray, without: Collection[int] = ()) -> FloatArray:
        return np.array([tendon_bend.bend_at(model, data, qpos, ids, without) for qpos in poses])

    rolling = [idler for idler in tendon_bend.idlers(model) if idler.tendon in ids]
    wheels = {idler.geom for idler in rolling}
    poses = tendon_bend.sampled_poses(model)
    parts = [poses]
    for without in [set(), wheels] if wheels else [set()]:
        for tendon, joints, bends in zip(ids, crossed, bends_in(poses, without).T, strict=True):
            parts.append(tendon_bend.extreme_poses(model, tendon, joints, poses, bends, without))
    poses = np.concatenate(parts)
    bends = bends_in(poses)
    return _Survey(
        spec,
        model,
        spec.compile(),
        sheaths_by_tendon(spec),
        tendons.actuators_by_tendon(spec),
        poses,
        bends,
        slid=bends_in(poses, wheels) if rolling else bends,
        idlers=rolling,
        limits=stiffness_limits(model, ids),
    )


def _tendon_row(
    survey: _Survey, k: int, tendon: tendons.Chosen, done: str, friction: float, extra_bend: float
) -> Row:
    """Row of the k-th tendon of a survey."""
    element, name = tendon.element, tendon.name
    sheath, actuators = survey.sheaths.get(name), survey.actuators.get(name, [])
    config = sheath.config if sheath else {}
    more = float(config.get("extra_bend", 0.0 if sheath else extra_bend))
    bend, slid_bend = (np.maximum(b[:, k] + more, 0.0) for b in (survey.bends, survey.slid))
    mu = float(config.get("friction", friction))
    stiffness, is_cable = config.get("axial_stiffness"), config.get("spring") == "cable"
    if is_cable and not stiffness:
        stiffness = own_elasticity(element, name, lambda: survey.after)[0]
    is_driven = not is_cable and "pretension" not in config
    wound_in = "reel_joint" in config or any(a.plugin.active for a in actuators)
    idle = idle_reason(element, config, is_driven=is_driven, is_wound_in=wound_in)
    branches, end = tendons.path_of(element).ends(), config.get("input_end", "first")
    site = branches[0][0] if end == "first" else branches[-1][1]
    return Row(
        tendon=name,
        bend=float(bend[0]),
        least_bend=float(bend.min()),
        most_bend=float(bend.max()),
        slid_bend=float(slid_bend[0]),
        most_slid_bend=float(slid_bend.max()),
        idlers=_idlers(survey, tendon, mu, float((bend - slid_bend).max())),
        friction=mu,
        axial_stiffness=float(stiffness) if stiffness else None,
        largest_stiffness=survey.limits[k],
        input=f"{end}, {site}" if sheath else "",
        drives=_drives(survey, tendon),
        done=done,
        sheath=sheath.name if sheath else "",
        acts=bool(sheath) and not idle,
        is_driven=is_driven,
        has_pulleys=len(branches) > 1,
    )


def _done(survey: _Survey, tendon: str, named: Collection[str], earlier: Collection[str]) -> str:
    """Change to a tendon, in words; ``earlier``: tendons that had a sheath before."""
    if tendon not in survey.sheaths:
        return "left as it was"
    sheath = survey.sheaths[tendon]
    if tendon in earlier:
        return f"left in sheath {sheath.name!r}"
    elasticity = ", its spring as elasticity" if sheath.config.get("spring") == "cable" else ""
    return f"{'named, ' if tendon in named else ''}sheath {sheath.name!r}{elasticity}"


def _unranged(survey: _Survey, rows: Sequence[Row]) -> list[str]:
    """Actuators of driven tendons that no range keeps from pushing."""
    return [
        f"{_label(actuator)} on {row.tendon}"
        for row in rows
        if row.sheath and row.is_driven
        for actuator in survey.actuators.get(row.tendon, [])
        if tendons.force_range(actuator, survey.spec.tendon(row.tendon)) is None
    ]


def _drives(survey: _Survey, tendon: tendons.Chosen) -> str:
    return (
        ", ".join(map(_label, survey.actuators.get(tendon.name, [])))
        or ("its spring" if tendons.has_own_spring(tendon.element) else "")
        or str(tendons.constraints_on(survey.spec, tendon.element))
        or "nothing"
    )


def _label(actuator: mujoco.MjsActuator) -> str:
    return actuator.name or f"actuator {actuator.id}"


def _idlers(survey: _Survey, tendon: tendons.Chosen, mu: float, bend: float) -> tuple[str, ...]:
    """Sentences of the guides that turn with a tendon, which bend it by ``bend`` at most."""
    model, sentences, most = survey.before, [], 1.0 - math.exp(-mu * bend)
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
    leading = tendon_bend.leading_joints(model, crossed)
    unswept = leading.intersection(tendon_bend.unswept_joints(model))
    held = [model.joint(joint).name or f"joint {joint}" for joint in sorted(unswept)]
    sentences = [f"held as in qpos0, as they have no range: {', '.join(held)}"] if held else []
    if (np.isin(model.eq_type, _LOOP_EQUALITIES) & (model.eq_active0 != 0)).any():
        sentences.append("the poses do not keep connect and weld constraints: bends may be less")
    return tuple(sentences)
