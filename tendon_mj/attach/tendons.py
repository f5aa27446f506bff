"""Tendons of a spec: those that a call means, their paths, and the forces that act on them."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Sequence
from fnmatch import fnmatchcase
from typing import Any, NamedTuple

import mujoco
import numpy as np

from tendon_mj.attach.instances import free_name
from tendon_mj.errors import InvalidValueError, UnknownNameError

_TENDON = mujoco.mjtObj.mjOBJ_TENDON
CABLE_DRIVE = (
    "where actuators turn joints by cables that are not drawn, give these friction by "
    'add_cable_drive(spec, "*", radius=…, bend=…, friction=…), or tendon-mj attach --actuator'
)
_WRAP, _GAIN, _BIAS = mujoco.mjtWrap, mujoco.mjtGain, mujoco.mjtBias


class Chosen(NamedTuple):
    """A tendon or an actuator that a call means."""

    element: Any
    name: str  # that it has or will have
    by_name: bool  # and not by a pattern


def check_spec(spec: object) -> None:
    """Refuse anything but an `MjSpec`, such as the path or the compiled model."""
    if not isinstance(spec, mujoco.MjSpec):
        raise InvalidValueError(
            f"spec must be a mujoco.MjSpec, not {type(spec).__name__}: read the MJCF with"
            " mujoco.MjSpec.from_file, and compile it afterwards"
        )


def asks_for_several(spec: mujoco.MjSpec, tendon: str | Sequence[str]) -> bool:
    """Return whether this is a list of names or a pattern, and not the name of a tendon."""
    return not isinstance(tendon, str) or (_is_pattern(tendon) and spec.tendon(tendon) is None)


def choose_tendons(spec: mujoco.MjSpec, tendon: str | Sequence[str]) -> list[Chosen]:
    """Tendons that a name, several names or patterns mean, as `choose` has it."""
    if len(spec.tendons) == 0 and len(spec.actuators) > 0:
        raise InvalidValueError(f"{listed(tendon)}: the model has no tendon; {CABLE_DRIVE}")
    return choose(list(spec.tendons), tendon, "tendon")


def choose(elements: Sequence[Any], names: str | Sequence[str], kind: str) -> list[Chosen]:
    """Elements that a name, several names or patterns mean, in the model's order.

    An element's name is that element's, even with the characters of a pattern. A pattern that
    matches any name, such as ``*``, also means those without a name, which are called
    ``<kind>_<k>``, k being their place in the model.
    """
    is_one = isinstance(names, str) or not isinstance(names, Iterable)
    wanted = [names] if is_one else list(names)
    if not wanted:
        raise InvalidValueError(f"no {kind} is named: give a name, several, or a pattern")
    known = {element.name: k for k, element in enumerate(elements) if element.name}
    chosen: dict[int, bool] = {}  # place in the model → by its name
    for name in wanted:
        if not isinstance(name, str):
            raise InvalidValueError(f"{name!r} is not the name of a {kind}")
        if name in known:
            chosen[known[name]] = True
        else:
            chosen = dict.fromkeys(_matching(elements, name, known, kind), False) | chosen
    taken, meant = set(known), []
    for k in sorted(chosen):
        name = elements[k].name or free_name(taken, f"{kind}_{k}")
        taken.add(name)
        meant.append(Chosen(elements[k], name, chosen[k]))
    return meant


def _matching(elements: Sequence[Any], pattern: str, known: dict[str, int], kind: str) -> list[int]:
    if not _is_pattern(pattern):
        raise UnknownNameError(kind, pattern, known)
    places = [k for k, element in enumerate(elements) if fnmatchcase(element.name, pattern)]
    if not places:
        there = ", ".join(map(repr, known)) or "none with a name"
        raise InvalidValueError(
            f"pattern {pattern!r} means no {kind} of the model (its {kind}s: {there})"
        )
    return places


def _is_pattern(tendon: str) -> bool:
    return any(character in tendon for character in "*?[")


def listed(names: str | Iterable[str]) -> str:
    """A name, or several, in quotes."""
    return ", ".join(map(repr, [names] if isinstance(names, str) else names))


class Branch(NamedTuple):
    """Stretch of a tendon between pulleys."""

    sites: tuple[str, ...] = ()  # names
    wraps: int = 0  # geoms that it may wrap around


class TendonPath(NamedTuple):
    """Path of a tendon."""

    branches: tuple[Branch, ...]  # one, and one more for each pulley
    is_spatial: bool  # whether it runs through space, not over joints

    @property
    def wraps(self) -> int:
        """Number of geoms that it may wrap around."""
        return sum(branch.wraps for branch in self.branches)

    def bends(self, arc_guides: int = 1) -> int:
        """Guides that can bend: the inner sites of each branch, `arc_guides` a geom."""
        within = sum(max(len(branch.sites) - 2, 0) for branch in self.branches)
        return within + self.wraps * arc_guides

    def guides(self, arc_guides: int = 1) -> int:
        """Number of guides: those that can bend, and one a pulley."""
        return self.bends(arc_guides) + len(self.branches) - 1

    def ends(self) -> list[tuple[str, str]]:
        """Names of the first and the last site of each branch."""
        return [(b.sites[0], b.sites[-1]) if b.sites else ("", "") for b in self.branches]


def path_of(tendon: mujoco.MjsTendon) -> TendonPath:
    """Path of a tendon."""
    branches, is_spatial = [Branch()], True
    for point in tendon.path:
        sites, wraps = branches[-1]
        if point.type == _WRAP.mjWRAP_JOINT:
            is_spatial = False
        elif point.type == _WRAP.mjWRAP_PULLEY:
            branches.append(Branch())
        elif point.type == _WRAP.mjWRAP_SITE:
            name = point.target.name if point.target is not None else ""
            branches[-1] = Branch((*sites, name), wraps)
        else:  # a sphere or a cylinder; which of the two is known once it is compiled
            branches[-1] = Branch(sites, wraps + 1)
    return TendonPath(tuple(branches), is_spatial)


def guides_are_beyond(tendon: mujoco.MjsTendon, input_end: str) -> bool:
    """Return whether all guides of an unbranched tendon are on the body at which it ends.

    Friction at a guide takes tension from the path behind it, which then pulls on one body alone.
    """
    points = list(tendon.path)
    if any(p.type == _WRAP.mjWRAP_PULLEY or p.target is None for p in points):
        return False
    return not _joints_between(points[1:] if input_end == "first" else points[:-1])


def crossed_joints(tendon: mujoco.MjsTendon) -> list[mujoco.MjsJoint]:
    """Joints that a spatial tendon crosses, or that a fixed one has in its sum."""
    if not path_of(tendon).is_spatial:
        return [point.target for point in tendon.path]
    points = [p for p in tendon.path if p.type != _WRAP.mjWRAP_PULLEY and p.target is not None]
    return _joints_between(points)


def only_joint(tendon: mujoco.MjsTendon) -> str:
    """The one joint of a fixed tendon; empty for any other."""
    points = list(tendon.path)
    is_one = len(points) == 1 and isinstance(points[0].target, mujoco.MjsJoint)
    return str(points[0].target.name) if is_one else ""


def idlers_are_possible(tendon: mujoco.MjsTendon) -> bool:
    """Return whether a tendon may wrap around a geom on a body that carries none of its sites."""
    targets = [point.target for point in tendon.path if point.type != _WRAP.mjWRAP_PULLEY]
    sites = [target for target in targets if isinstance(target, mujoco.MjsSite)]
    carriers = {body for site in sites for body in _above(site.parent)}
    return any(
        body.joints and body not in carriers
        for geom in targets
        if isinstance(geom, mujoco.MjsGeom)
        for body in _above(geom.parent)
    )


def _joints_between(points: Sequence[mujoco.MjsWrap]) -> list[mujoco.MjsJoint]:
    """Joints between the bodies of points on a path."""
    chains = [_above(point.target.parent) for point in points]
    bodies = dict.fromkeys(body for chain in chains for body in chain)
    return [
        joint
        for body in bodies
        if not all(body in chain for chain in chains)
        for joint in body.joints
    ]


def _above(body: mujoco.MjsBody) -> list[mujoco.MjsBody]:
    """A body and all that carry it."""
    chain = [body]
    while chain[-1].name != "world":  # whose parent some releases of MuJoCo do not survive
        chain.append(chain[-1].parent)
    return chain


def is_limited(limited: int, ends: Sequence[float]) -> bool:
    """Return whether a range of a spec limits, which by default it does where it is one."""
    if int(limited) == mujoco.mjtLimited.mjLIMITED_AUTO:
        return bool(ends[0] < ends[1])
    return int(limited) == int(mujoco.mjtLimited.mjLIMITED_TRUE)


def is_cable(spec: mujoco.MjSpec, tendon: mujoco.MjsTendon) -> bool:
    """Return whether `add_cable_drive` added a tendon, and nothing else refers to it."""
    is_one = bool(only_joint(tendon))
    shown = [s.objname for s in spec.sensors if s.objtype == _TENDON and not s.plugin.active]
    actuated = tendon.name in actuators_by_tendon(spec)
    held = constraints_on(spec, tendon) != Constraints()
    return is_one and not (actuated or held or has_own_spring(tendon) or tendon.name in shown)


def has_own_spring(tendon: mujoco.MjsTendon) -> bool:
    """Return whether a tendon has its own stiffness."""
    return any(float(k) for k in tendon.stiffness)


class Constraints(NamedTuple):
    """Constraints of MuJoCo's that may act along a tendon."""

    equalities: tuple[str, ...] = ()  # by name
    longest: float | None = None  # length at which its limit ends it [m]

    def __str__(self) -> str:
        names = [f"equality {name!r}" if name else "an equality" for name in self.equalities]
        return " and ".join(names + ["its limit"] * (self.longest is not None))


def constraints_on(spec: mujoco.MjSpec, tendon: mujoco.MjsTendon) -> Constraints:
    """Constraints that may act along a tendon of a spec."""
    names = tuple(
        equality.name
        for equality in spec.equalities
        if equality.type == mujoco.mjtEq.mjEQ_TENDON
        and tendon.name in (equality.name1, equality.name2)
    )
    longest = float(tendon.range[1]) if is_limited(tendon.limited, tendon.range) else None
    return Constraints(names if tendon.name else (), longest)


def name_of(actuator: mujoco.MjsActuator) -> str:
    """An actuator for messages: its name, or its number if it has none."""
    return repr(actuator.name) if actuator.name else f"actuator {actuator.id}, which has no name"


def actuators_by_tendon(spec: mujoco.MjSpec) -> dict[str, list[mujoco.MjsActuator]]:
    """Tendon → the actuators on it."""
    actuators: dict[str, list[mujoco.MjsActuator]] = {}
    for actuator in spec.actuators:
        if actuator.trntype == mujoco.mjtTrn.mjTRN_TENDON:
            actuators.setdefault(actuator.target, []).append(actuator)
    return actuators


def force_sensors(spec: mujoco.MjSpec, joints: Collection[str]) -> list[str]:
    """Names of the sensors of actuators' forces on these joints (jointactuatorfrc)."""
    kind = mujoco.mjtSensor.mjSENS_JOINTACTFRC
    return [s.name for s in spec.sensors if s.type == kind and s.objname in joints]


def force_range(
    actuator: mujoco.MjsActuator, on: mujoco.MjsTendon | mujoco.MjsJoint
) -> tuple[float, float] | None:
    """Least and largest force of an actuator on a tendon or joint that its ranges allow [N or N m].

    A pull is below 0, a push above. A servo without a range can do both; an actuator whose force is
    not a polynomial, such as a muscle, is taken to pull. None for a motor without a range, which
    does not state whether it may push.
    """
    gain, bias = list(actuator.gainprm[:3]), list(actuator.biasprm[:3])
    is_linear = actuator.gaintype in (_GAIN.mjGAIN_FIXED, _GAIN.mjGAIN_AFFINE)
    if not is_linear or actuator.biastype not in (_BIAS.mjBIAS_NONE, _BIAS.mjBIAS_AFFINE):
        return -math.inf, 0.0
    if actuator.gaintype == _GAIN.mjGAIN_FIXED:
        gain[1:] = 0.0, 0.0
    if actuator.biastype == _BIAS.mjBIAS_NONE:
        bias = [0.0, 0.0, 0.0]
    control = (actuator.ctrllimited, actuator.ctrlrange)
    if actuator.dyntype == mujoco.mjtDyn.mjDYN_INTEGRATOR:
        control = (actuator.actlimited, actuator.actrange)
    force, is_stated = np.array([-np.inf, np.inf]), any((*gain[1:], *bias[1:]))
    if not is_stated and is_limited(*control):
        force, is_stated = np.sort(gain[0] * np.array(control[1]) + bias[0]), True
    if is_limited(actuator.forcelimited, actuator.forcerange):
        force, is_stated = force.clip(*actuator.forcerange), True
    gear = float(actuator.gear[0])
    force = np.sort(gear * force) if gear else np.zeros(2)
    if is_limited(on.actfrclimited, on.actfrcrange):
        force = force.clip(*on.actfrcrange)
    is_stated = is_stated or bool(force[1] <= 0.0)
    return (float(force[0]), float(force[1])) if is_stated else None
