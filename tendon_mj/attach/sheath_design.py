"""Design of the sheath on a tendon: its drive, its elasticity, and so its configuration."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Callable, Iterable, Mapping
from typing import NamedTuple

import mujoco

from tendon_mj.attach.instances import sheaths_by_tendon
from tendon_mj.attach.spool import Spool, SpoolDesign, design_spool
from tendon_mj.attach.stiffness_limit import step_warning
from tendon_mj.attach.tendons import (
    Chosen,
    Constraints,
    TendonPath,
    actuators_by_tendon,
    constraints_on,
    guides_are_beyond,
    has_own_spring,
    name_of,
    path_of,
)
from tendon_mj.errors import InvalidValueError, UnsuitedTendonError
from tendon_mj.sheath import Law

_RUB_UNBENT = ("extra_bend", "constant_friction", "viscous_friction")
_IS_FIXED = (
    "is fixed, a sum of joint positions without a path that bends: give the actuator that pulls it "
    "a cable drive, add_cable_drive(spec, {}, radius=…, bend=…, friction=…), whatever the unit of "
    "its coefficients, or draw it as a spatial tendon over sites or cylinders"
)
_BRANCHES = (
    "branches at a pulley, behind its site {!r}, and every branch has its input where it begins: "
    "leave out input_end and draw each branch from its input on, or make each a separate tendon"
)
_UNBENT = "with nothing to bend over: give extra_bend [rad], or route it over more sites"
_GUIDES_BEYOND = (
    "all of whose guides are on the body at which it ends, so that every joint feels its input "
    "tension: route it over sites of other bodies, or give extra_bend [rad] and inner_guides"
)
_HELD_AT_INPUT = (
    "all of whose guides are at its {} site, where nothing winds it in: route it over more "
    "sites, or let a reel, a reel_joint or an actuator pull there"
)
_PASSING = "{} pulls along the whole tendon, past the sheath that {} it: remove it"
_OR_DRIVES = ", or leave pretension and slack out, so that it gives the input tension"
_SHORTER = "; its range lets the tendon be {:.3g} mm longer than the sheath does"
_SAME_LENGTH = 1e-9  # relative, of two lengths


class Request(NamedTuple):
    """Request of a call, for each of its tendons; see `add_friction`."""

    law: Law  # with some EA and T_0 if none is given
    axial_stiffness: float | None
    pretension: float | None
    arc_guides: int
    inner_guides: int | None
    input_end: str
    ends: Mapping[str, str]  # attributes of reel_joint and output_joint
    is_wound: bool  # by a reel or a spool, in or out
    is_wound_in: bool  # at the input
    spool: Spool | None
    spring: str


class NewSheath(NamedTuple):
    """A sheath that a call adds."""

    tendon: mujoco.MjsTendon
    name: str  # that the tendon has or will have
    config: dict[str, str]  # of the plugin instance, but for the tendon's name
    is_driven: bool  # whether MuJoCo's forces along the tendon give the input tension
    idle: str = ""  # why friction can do nothing, and the remedy
    passing: str = ""  # force that passes the sheath, and the remedy
    too_stiff: str = ""  # for the time step, and the remedy
    spool: SpoolDesign | None = None


class Designer:
    """Designs the sheaths that a request leads to; it does not change the spec."""

    def __init__(self, spec: mujoco.MjSpec, request: Request) -> None:
        self._spec, self._request = spec, request
        self._sheathed, self._actuators = sheaths_by_tendon(spec), actuators_by_tendon(spec)
        # not a copy, which would drop elements that nothing refers to
        self._compiled = functools.cache(spec.compile)

    def design_all(self, chosen: Iterable[Chosen]) -> tuple[list[NewSheath], dict[str, str]]:
        """Sheaths to be added; tendons that a pattern leaves out → why.

        A tendon that was given by its name and cannot have a sheath is refused.
        """
        sheaths, left_out = [], {}
        for tendon, name, by_name in chosen:
            try:
                sheaths.append(self._design(tendon, name))
            except UnsuitedTendonError as error:
                if by_name:
                    raise
                left_out[name] = str(error)
        return sheaths, left_out

    def _design(self, tendon: mujoco.MjsTendon, name: str) -> NewSheath:
        """The sheath of a tendon.

        A tendon that an actuator pulls is *driven*: the force on it is its input tension. Any other
        is *wound*: its own spring is the cable's elasticity where it can be, and where it cannot,
        or is not to be, it drives the tendon. So does the spring of a tendon that has no guide but
        at its input end: friction there acts only on the tendon that comes in. A tendon that only
        an equality or a limit pulls, and whose length is not stated, is driven by these.
        """
        request, path, actuators = self._request, path_of(tendon), self._actuators.get(name, [])
        if name in self._sheathed:
            sheath = self._sheathed[name].name
            raise UnsuitedTendonError(f"tendon {name!r} already runs in sheath {sheath!r}")
        if not path.is_spatial:
            pullers = ", ".join(name_of(actuator) for actuator in actuators) or '"…"'
            raise UnsuitedTendonError(f"tendon {name!r} {_IS_FIXED.format(pullers)}")
        if request.input_end == "last" and len(path.branches) > 1:
            site = path.ends()[0][1]
            raise UnsuitedTendonError(f"tendon {name!r} {_BRANCHES.format(site)}")
        inner, constraints = _inner_guides(path, request), constraints_on(self._spec, tendon)
        is_driven = bool(actuators) and not request.is_wound
        if is_driven and request.pretension is not None:
            raise InvalidValueError(
                f"tendon {name!r} is driven by {' and '.join(map(name_of, actuators))}, "
                "whose force is its input tension: leave pretension out"
            )
        if actuators and request.is_wound_in and not request.spool:
            raise UnsuitedTendonError(
                f"actuator {name_of(actuators[0])} pulls on tendon {name!r} as a whole, past the"
                " reel that would wind it; remove one of them"
            )
        if not is_driven:
            if request.law.slack and request.pretension is None and not has_own_spring(tendon):
                request = request._replace(pretension=0.0)
            only_inner = inner > 0 and path.bends() == 0
            is_driven = self._drives_itself(tendon, name, request, constraints, only_inner)
        is_cable = not is_driven and has_own_spring(tendon)
        config = _sheath_config(path, request, inner, is_driven=is_driven, is_cable=is_cable)
        idle = idle_reason(tendon, config, is_driven=is_driven, is_wound_in=request.is_wound_in)
        passing = (
            "" if is_driven else _passing_warning(constraints, tendon, request, self._compiled)
        )
        config |= request.ends
        at_last, compiled = request.input_end == "last", self._compiled
        spool = design_spool(
            self._spec, tendon, name, request.spool, at_last, config, actuators, compiled
        )
        too_stiff = "" if spool else self._step_warning(tendon, is_driven)
        return NewSheath(tendon, name, config, is_driven, idle, passing, too_stiff, spool)

    def _step_warning(self, tendon: mujoco.MjsTendon, driven: bool) -> str:
        """`step_warning` of a stated EA, if the model is as complete as to be compiled."""
        if self._request.axial_stiffness is None:
            return ""
        try:
            model = self._compiled()
        except ValueError:
            return ""
        return step_warning(model, tendon.id, self._request.axial_stiffness, driven=driven)

    def _drives_itself(
        self,
        tendon: mujoco.MjsTendon,
        name: str,
        request: Request,
        constraints: Constraints,
        only_inner: bool,
    ) -> bool:
        """Return whether the spring or the constraints of a tendon without actuators drive it.

        A spring that cannot be the elasticity of a wound tendon does.
        """
        may_be = request.pretension is None and not request.law.slack and not request.is_wound
        has_spring = has_own_spring(tendon)
        is_input = only_inner or request.spring == "input"
        if may_be and (is_input if has_spring else constraints != Constraints()):
            return True
        if request.axial_stiffness is not None and request.pretension is not None:
            return False
        try:
            stiffness, pretension = own_elasticity(tendon, name, self._compiled)
        except UnsuitedTendonError:
            if not (may_be and has_spring):
                raise
            return True
        # in range at the moment; the sheath reads them from the model
        dataclasses.replace(request.law, axial_stiffness=stiffness, pretension=pretension)
        return False


def _sheath_config(
    path: TendonPath, request: Request, inner: int, *, is_driven: bool, is_cable: bool
) -> dict[str, str]:
    counts = {"guides": path.guides(request.arc_guides) + inner}
    if path.wraps:
        counts["arc_guides"] = request.arc_guides
    if inner:
        counts["inner_guides"] = inner
    config = {k: str(count) for k, count in counts.items()}
    if request.input_end != "first":
        config["input_end"] = request.input_end
    law = dataclasses.asdict(request.law)
    config |= {k: repr(v) for k, v in law.items() if v or k == "friction"}
    if is_driven or is_cable:
        del config["axial_stiffness"]
    if is_cable:
        config["spring"] = "cable"
    given = {"axial_stiffness": request.axial_stiffness, "pretension": request.pretension}
    return config | {k: repr(v) for k, v in given.items() if v is not None}


def idle_reason(
    tendon: mujoco.MjsTendon, config: Mapping[str, str], *, is_driven: bool, is_wound_in: bool
) -> str:
    """Reason that friction of a sheath has no effect, and the remedy; empty if it has."""
    inner, end = int(config.get("inner_guides", 0)), config.get("input_end", "first")
    if path_of(tendon).bends() == 0:
        if not (inner and any(float(config.get(key, 0.0)) > 0.0 for key in _RUB_UNBENT)):
            return _UNBENT
        if not is_driven and not is_wound_in:
            return _HELD_AT_INPUT.format(end)
    elif is_driven and not inner and guides_are_beyond(tendon, end):
        return _GUIDES_BEYOND
    return ""


def _passing_warning(
    constraints: Constraints,
    tendon: mujoco.MjsTendon,
    request: Request,
    compiled: Callable[[], mujoco.MjModel],
) -> str:
    """Warning of constraints past the sheath of a tendon that is not driven."""
    if request.is_wound:  # the limit is the end of its travel
        constraints = constraints._replace(longest=None)
    if constraints == Constraints():
        return ""
    rest = float(compiled().tendon_length0[tendon.id]) + request.law.slack
    warning = _PASSING.format(constraints, "winds" if request.is_wound else "holds")
    warning += "" if request.is_wound else _OR_DRIVES
    if constraints.longest is None or constraints.longest <= rest * (1.0 + _SAME_LENGTH):
        return warning
    return warning + _SHORTER.format(1e3 * (constraints.longest - rest))


def _inner_guides(path: TendonPath, request: Request) -> int:
    """Guides at the input end: as given, or one for friction that needs a guide in every pose.

    Guides on geoms are not there in every pose.
    """
    law = request.law
    if request.inner_guides is not None:
        return request.inner_guides
    if path.bends() == 0:
        return int(any(getattr(law, key) > 0.0 for key in _RUB_UNBENT))
    undrawn = law.extra_bend > 0.0 or law.constant_friction > 0.0
    return int(undrawn and path.bends(arc_guides=0) == 0)


def own_elasticity(
    tendon: mujoco.MjsTendon, name: str, compiled: Callable[[], mujoco.MjModel]
) -> tuple[float, float]:
    """EA and T_0 [N] equivalent to a tendon's stiffness k and spring length S at `qpos0`.

    EA = k S and T_0 = k (L(qpos0) − S), so that the sheath pulls as the spring did where it pulled.
    """
    where, advice = f"tendon {name!r}", "give axial_stiffness [N] and pretension [N]"
    stiffness = [float(k) for k in tendon.stiffness]
    if not any(stiffness):
        raise UnsuitedTendonError(
            f"{where} has no stiffness to take over, and no actuator acts on it: {advice}, or"
            " add friction after the actuators (in mjlab in SceneCfg.spec_fn, not an entity's)"
        )
    if not stiffness[0] > 0.0 or any(stiffness[1:]):
        raise UnsuitedTendonError(
            f"{where} has a stiffness that is a polynomial or negative, {stiffness}; a sheath's is "
            f"positive and linear: {advice}"
        )
    if len(path_of(tendon).branches) > 1:
        raise UnsuitedTendonError(
            f"{where} runs over pulleys, and its spring is one of all branches together: {advice}"
        )
    model = compiled()
    length = float(model.tendon_length0[tendon.id])
    shortest, longest = map(float, model.tendon_lengthspring[tendon.id])
    reason = ""
    if not longest > 0.0:
        reason = "has springlength = 0, so no strain is defined"
    elif 0.0 < shortest < longest:
        reason = f"has a dead band, springlength = {shortest:g} {longest:g} [m]"
    elif longest > length * (1.0 + 1e-9):
        reason = f"is slack at qpos0 by {longest - length:g} m, which no pretension ≥ 0 says"
    if reason:
        raise UnsuitedTendonError(f"{where} {reason}: {advice} instead")
    return stiffness[0] * longest, max(0.0, stiffness[0] * (length - longest))
