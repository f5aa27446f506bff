"""Design of the sheath on a tendon: what drives it, its elasticity, and so its configuration."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from typing import NamedTuple, SupportsFloat

import mujoco

from tendon_mj.attach.elasticity import own_elasticity
from tendon_mj.attach.keywords import as_number
from tendon_mj.attach.spring import has_spring
from tendon_mj.attach.tendon_path import path_of
from tendon_mj.errors import InvalidValueError, UnsuitedTendonError
from tendon_mj.sheath.law import LAW, Law


class Request(NamedTuple):
    """What a call asks for, of each of its tendons.

    Attributes:
        law: parameters of `Law` by name; EA and T_0 may be None.
        arc_guides: inner guides on each geom that a tendon may wrap around.
        ends: attributes of spools.
        is_wound: whether a reel or a spool winds tendon in or out.
    """

    law: Mapping[str, SupportsFloat | None]
    arc_guides: int
    ends: Mapping[str, str]
    is_wound: bool


class Design(NamedTuple):
    """A sheath that can be added.

    Attributes:
        config: of the plugin instance, but for the tendon's name.
        takes_spring: whether the tendon's own spring moves into the sheath.
        can_rub: whether there is a guide, or bend that is not drawn.
    """

    config: dict[str, str]
    takes_spring: bool
    can_rub: bool


def design_sheath(
    tendon: mujoco.MjsTendon,
    name: str,
    request: Request,
    actuators: list[str],
    compiled: Callable[[], mujoco.MjModel],
) -> Design:
    """The sheath that a request means for a tendon.

    A tendon that an actuator pulls is *driven*: the force on it is its input tension, and its own
    spring stays where it is. Any other is *wound*: its own spring moves into the sheath where it
    can, and where it cannot it drives the tendon.

    Args:
        tendon: of a spec.
        name: of the tendon, or the one that it will have.
        request: what is asked for.
        actuators: names of those on the tendon.
        compiled: returns the compiled spec.

    Raises:
        UnsuitedTendonError: a tendon that cannot run in a sheath, or that nothing pulls.
        InvalidValueError: a parameter outside its range, or that a driven tendon has not.
    """
    path = path_of(tendon)
    if not path.is_spatial:
        raise UnsuitedTendonError(
            f"tendon {name!r} is a fixed one, over joints; a sheath needs a spatial one"
        )
    stiffness, pretension = (
        None if request.law[key] is None else as_number(key, request.law[key])
        for key in ("axial_stiffness", "pretension")
    )
    is_driven = False
    if actuators and not request.is_wound:
        if pretension is not None:
            raise InvalidValueError(
                f"tendon {name!r} is driven by {' and '.join(map(repr, actuators))}, whose force "
                "is its input tension: leave pretension out"
            )
        is_driven = True
    elif stiffness is None or pretension is None:
        try:
            own = own_elasticity(tendon, name, compiled, len(path.branches))
        except UnsuitedTendonError:
            is_driven = has_spring(tendon) and pretension is None and not request.is_wound
            if not is_driven:
                raise
        else:
            stiffness = own[0] if stiffness is None else stiffness
            pretension = own[1] if pretension is None else pretension
    law = _law(request, stiffness, pretension)
    guides = path.guides(request.arc_guides)
    config = {"guides": str(guides)}
    if path.wraps:
        config["arc_guides"] = str(request.arc_guides)
    config |= {k: repr(v) for k, v in dataclasses.asdict(law).items() if v or k == "friction"}
    if is_driven:
        del config["axial_stiffness"]
    if stiffness is not None:
        config["axial_stiffness"] = repr(stiffness)
    if pretension is not None:
        config["pretension"] = repr(pretension)
    can_rub = guides > 0 or law.extra_bend != 0.0
    return Design(config | dict(request.ends), not is_driven, can_rub)


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
