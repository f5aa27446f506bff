"""Design of the sheath on a tendon: what drives it, its elasticity, and so its configuration."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple, SupportsFloat

import mujoco

from tendon_mj.attach.elasticity import Constraints, has_spring, own_elasticity
from tendon_mj.attach.keywords import as_number
from tendon_mj.attach.sheathed import name_of
from tendon_mj.attach.spool import Spool
from tendon_mj.attach.tendon_path import TendonPath, end_sites, guides_are_beyond, path_of
from tendon_mj.errors import InvalidValueError, UnsuitedTendonError
from tendon_mj.sheath import LAW, Law

_RUB_UNBENT = ("extra_bend", "constant_friction", "viscous_friction")
_FIXED = (
    "is fixed, a sum of joint positions without a path that bends: draw it as a spatial tendon, "
    "over sites or cylinders as far from the axis of each hinge as its coefficient [m] says; or, "
    "for a loss that does not grow with the tension, give the tendon frictionloss [N]"
)
_UNBENT = "with nothing to bend over: give extra_bend [rad], or route it over more sites"
_BEYOND = (
    "all of whose guides are on the body at which it ends, so that every joint feels its input "
    "tension: route it over sites of other bodies, or give extra_bend [rad] and inner_guides"
)
_HELD = (
    "all of whose guides are at its {} site, where nothing winds it in: route it over more "
    "sites, or let a reel, a reel_joint or an actuator pull there"
)


_PASSING = "{} pulls along the whole tendon, past the sheath that {} it: remove it"
_OR_DRIVES = ", or leave pretension and slack out, so that it gives the input tension"
_SHORTER = "; its range lets the tendon be {:.3g} mm longer than the sheath does"


_SAME = 1e-9  # relative, of two lengths


class Request(NamedTuple):
    """Request of a call, for each of its tendons.

    Attributes:
        law: parameters of `Law` by name; EA and T_0 may be None.
        arc_guides: guides on each geom that a tendon may wrap around.
        inner_guides: guides at its input end; None for as many as what is asked for needs.
        input_end: its site that is its input end, one of `INPUT_ENDS`.
        ends: attributes of spools.
        is_wound: whether a reel or a spool winds tendon in or out.
        is_wound_in: whether one does so at the input.
        spool: that the tendon's actuators are to turn.
        spring: what a tendon's own spring stands for, one of `SPRINGS`.
        timestep: of the model [s].
    """

    law: Mapping[str, SupportsFloat | None]
    arc_guides: int
    inner_guides: int | None
    input_end: str
    ends: Mapping[str, str]
    is_wound: bool
    is_wound_in: bool
    spool: Spool | None
    spring: str
    timestep: float


class Design(NamedTuple):
    """A sheath that can be added.

    Attributes:
        config: of the plugin instance, but for the tendon's name.
        idle: why friction can do nothing, and the remedy; empty where it can.
        passing: force that passes the sheath, and the remedy; empty where none does.
        is_driven: whether MuJoCo's forces along the tendon give the input tension.
    """

    config: dict[str, str]
    idle: str
    passing: str
    is_driven: bool


def design_sheath(
    tendon: mujoco.MjsTendon,
    name: str,
    request: Request,
    actuators: Sequence[mujoco.MjsActuator],
    constraints: Constraints,
    compiled: Callable[[], mujoco.MjModel],
) -> Design:
    """The sheath that a request means for a tendon.

    A tendon that an actuator pulls is *driven*: the force on it is its input tension. Any other is
    *wound*: its own spring is the cable's elasticity where it can be, and where it cannot, or is
    not to be, it drives the tendon. So does the spring of a tendon that has no guide but at its
    input end: friction there acts only on what comes in. A tendon that only an equality or a limit
    pulls, and whose length is not stated, is driven by these.

    Args:
        tendon: of a spec.
        name: of the tendon, or the one that it will have.
        request: what is asked for.
        actuators: on the tendon.
        constraints: that may act along it.
        compiled: returns the compiled spec.

    Raises:
        UnsuitedTendonError: a tendon that cannot run in a sheath, or that nothing pulls.
        InvalidValueError: a parameter outside its range, or that a driven tendon has not.
    """
    path = path_of(tendon)
    if not path.is_spatial:
        raise UnsuitedTendonError(f"tendon {name!r} {_FIXED}")
    if request.input_end == "last" and len(path.branches) > 1:
        raise UnsuitedTendonError(
            f"tendon {name!r} branches at a pulley, behind its site {end_sites(tendon)[0][1]!r}, "
            "and every branch has its input where it begins: leave out input_end and draw each "
            "branch from its input on, or give each a tendon of its own"
        )
    stiffness, pretension = (
        None if request.law[key] is None else as_number(key, request.law[key])
        for key in ("axial_stiffness", "pretension")
    )
    if request.spool is not None:
        if stiffness is None:
            raise InvalidValueError(
                f"tendon {name!r} is to be wound by a spool: give axial_stiffness [N]"
            )
        if pretension is None and request.law.get("slack") is None:
            pretension = 0.0
        damping = {"axial_damping": stiffness * request.timestep}
        request = request._replace(law=damping | dict(request.law))
    inner = _inner_guides(path, _law(request, stiffness, pretension), request.inner_guides)
    only_inner = inner > 0 and path.bends() == 0
    if actuators and not request.is_wound:
        if pretension is not None:
            raise InvalidValueError(
                f"tendon {name!r} is driven by {' and '.join(map(name_of, actuators))}, "
                "whose force is its input tension: leave pretension out"
            )
        is_driven = True
    else:
        may_be_driven = pretension is None and not request.law.get("slack") and not request.is_wound
        if has_spring(tendon):
            is_driven = may_be_driven and (only_inner or request.spring == "input")
        else:
            is_driven = may_be_driven and constraints != Constraints()
        if request.law.get("slack") and pretension is None and not has_spring(tendon):
            pretension = 0.0
        if not is_driven and (stiffness is None or pretension is None):
            try:
                own = own_elasticity(tendon, name, compiled, len(path.branches))
            except UnsuitedTendonError:
                if not (may_be_driven and has_spring(tendon)):
                    raise
                is_driven = True
            else:  # as they are at the moment; the sheath reads them from the model
                _law(request, *own)
    is_cable = not is_driven and has_spring(tendon)
    law = _law(request, stiffness, pretension)
    counts = {"guides": path.guides(request.arc_guides) + inner}
    if path.wraps:
        counts["arc_guides"] = request.arc_guides
    if inner:
        counts["inner_guides"] = inner
    config = {k: str(count) for k, count in counts.items()}
    if request.input_end != "first":
        config["input_end"] = request.input_end
    config |= {k: repr(v) for k, v in dataclasses.asdict(law).items() if v or k == "friction"}
    if is_driven or is_cable:
        del config["axial_stiffness"]
    if is_cable:
        config["spring"] = "cable"
    if stiffness is not None:
        config["axial_stiffness"] = repr(stiffness)
    if pretension is not None:
        config["pretension"] = repr(pretension)
    idle = idle_reason(tendon, config, is_driven=is_driven, is_wound_in=request.is_wound_in)
    passing = ""
    if not is_driven and request.is_wound:  # whose limit is the end of its travel
        constraints = constraints._replace(longest=None)
    if not is_driven and constraints != Constraints():
        rest = float(compiled().tendon_length0[tendon.id]) + law.slack
        passing = _passing(constraints, rest, request.is_wound)
    return Design(config | dict(request.ends), idle, passing, is_driven)


def idle_reason(
    tendon: mujoco.MjsTendon, config: Mapping[str, str], *, is_driven: bool, is_wound_in: bool
) -> str:
    """Why friction of a sheath can do nothing, and the remedy; empty where it can.

    Args:
        tendon: of a spec.
        config: of the sheath.
        is_driven: whether an actuator or the tendon's own spring gives the input tension.
        is_wound_in: whether a reel or a spool winds tendon in at the input.
    """
    inner, end = int(config.get("inner_guides", 0)), config.get("input_end", "first")
    if path_of(tendon).bends() == 0:
        if not (inner and any(float(config.get(key, 0.0)) > 0.0 for key in _RUB_UNBENT)):
            return _UNBENT
        if not is_driven and not is_wound_in:
            return _HELD.format(end)
    elif is_driven and not inner and guides_are_beyond(tendon, end):
        return _BEYOND
    return ""


def _passing(constraints: Constraints, rest: float, is_wound: bool) -> str:
    """Warning of constraints past the sheath of a tendon whose unstretched length is ``rest``."""
    said = _PASSING.format(constraints, "winds" if is_wound else "holds")
    said += "" if is_wound else _OR_DRIVES
    if constraints.longest is None or constraints.longest <= rest * (1.0 + _SAME):
        return said
    return said + _SHORTER.format(1e3 * (constraints.longest - rest))


def _inner_guides(path: TendonPath, law: Law, asked: int | None) -> int:
    """Guides at the input end: as many as asked for, or one for what is not drawn.

    That needs a guide that is there in every pose, as those on geoms are not.
    """
    if asked is not None:
        return asked
    if path.bends() == 0:
        return int(_rubs_unbent(law))
    undrawn = law.extra_bend > 0.0 or law.constant_friction > 0.0
    return int(undrawn and not path.is_bent_at_sites)


def _rubs_unbent(law: Law) -> bool:
    """Whether there is friction at a guide at which the drawn path does not bend."""
    return any(getattr(law, key) > 0.0 for key in _RUB_UNBENT)


def _law(request: Request, stiffness: float | None, pretension: float | None) -> Law:
    """The law of a sheath, its parameters checked; one whose EA is left to the step has any."""
    elasticity = {
        "axial_stiffness": 1.0 if stiffness is None else stiffness,
        "pretension": 0.0 if pretension is None else pretension,
    }
    values = {k: _parameter(k, v) for k, v in (dict(request.law) | elasticity).items()}
    return Law(**values)  # type: ignore[arg-type]


def _parameter(name: str, value: SupportsFloat | None) -> float | None:
    """A parameter of the law as a number; None where the law allows it."""
    if value is None and not LAW[name].required and LAW[name].default is None:
        return None
    return as_number(name, value)
