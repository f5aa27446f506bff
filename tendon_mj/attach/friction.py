"""Gives a tendon of a model a sheath with friction."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from typing import SupportsFloat, Unpack

import mujoco

from tendon_mj.attach.elasticity import own_elasticity
from tendon_mj.attach.instance import add_instance
from tendon_mj.attach.keywords import as_number, check_names, takes
from tendon_mj.attach.sensor import add_sensor, check_kinds, free_name
from tendon_mj.engine import NAME
from tendon_mj.errors import InvalidValueError, UnknownNameError
from tendon_mj.sheath.law import LAW, Law, OptionalParameters

_SITE = mujoco.mjtWrap.mjWRAP_SITE


@takes(LAW)
def add_friction(
    spec: mujoco.MjSpec,
    tendon: str,
    *,
    friction: float,
    axial_stiffness: float | None = None,
    pretension: float | None = None,
    name: str | None = None,
    reel: str | None = None,
    reel_joint: str | None = None,
    reel_radius: float | None = None,
    output_joint: str | None = None,
    output_radius: float | None = None,
    sensors: Sequence[str] = ("input_tension", "output_tension"),
    **parameters: Unpack[OptionalParameters],
) -> mujoco.MjSpec:
    """Let a spatial tendon run through a sheath with Coulomb friction.

    The tendon's own stiffness moves into the sheath: EA and T_0 default to its stiffness times its
    spring length and the pull of its spring at `qpos0`, and it is set to 0 on the tendon.

    Args:
        spec: changed in place and returned.
        tendon: name of a spatial tendon over sites; its first site is the input end.
        <parameters>
        name: of the sheath, default ``sheath`` or, where that is taken, ``<tendon>_sheath``.
        reel: name of an actuator to add that winds tendon in at the input, control in metres.
            Without one, a sensor named like the sheath is added, which shows T_in and T_out.
        reel_joint, reel_radius: joint [rad] or slide whose motion winds tendon in, and radius [m].
        output_joint, output_radius: the same at the output end.
        sensors: kinds to add, named like the kind, or ``<name>_<kind>`` where that is taken.

    Returns:
        ``spec``.

    Raises:
        UnknownNameError: no such tendon, parameter or sensor kind, with the nearest name.
        InvalidValueError: a parameter outside its range, or a second sheath on the tendon.
    """
    check_names(LAW, parameters, "add_friction")
    element = _find_tendon(spec, tendon)
    check_kinds(sensors)
    if axial_stiffness is None or pretension is None:
        own_stiffness, own_pretension = own_elasticity(spec, tendon)
        axial_stiffness = own_stiffness if axial_stiffness is None else axial_stiffness
        pretension = own_pretension if pretension is None else pretension
    values = parameters | {
        "friction": friction,
        "axial_stiffness": axial_stiffness,
        "pretension": pretension,
    }
    law = Law(**{k: _parameter(k, v) for k, v in values.items()})  # type: ignore[arg-type]
    config = {"tendon": tendon, "guides": str(len(element.path) - 2)}
    config |= {k: repr(v) for k, v in dataclasses.asdict(law).items() if v}
    config |= {k: repr(getattr(law, k)) for k in ("axial_stiffness", "friction", "pretension")}
    config |= _spool(spec, "reel", reel_joint, reel_radius)
    config |= _spool(spec, "output", output_joint, output_radius)
    if reel is not None and reel in [actuator.name for actuator in spec.actuators]:
        raise InvalidValueError(f"the model already has an actuator {reel!r}")
    if name is None:
        taken = [plugin.name for plugin in spec.plugins]
        name = "sheath" if "sheath" not in taken else f"{tendon}_sheath"
    spec.activate_plugin(NAME)
    sheath = add_instance(spec, name, config, NAME)
    element.stiffness[:] = 0.0
    element.springlength[:] = -1.0
    _refer(spec, sheath, name, tendon, reel)
    for kind in sensors:
        add_sensor(spec, name, kind)
    return spec


def _refer(
    spec: mujoco.MjSpec, sheath: mujoco.MjsPlugin, name: str, tendon: str, reel: str | None
) -> None:
    """Let its reel or a sensor refer to a sheath, which `MjSpec.copy` and attach would lose."""
    if reel is not None:
        actuator = spec.add_actuator(name=reel, trntype=mujoco.mjtTrn.mjTRN_TENDON, target=tendon)
        actuator.plugin = sheath
        return
    ends = spec.add_sensor(
        name=free_name(spec, name, f"{name}_ends"), type=mujoco.mjtSensor.mjSENS_PLUGIN
    )
    ends.plugin = sheath


def _find_tendon(spec: mujoco.MjSpec, name: str) -> mujoco.MjsTendon:
    """A tendon that can run in a sheath and does not yet."""
    known = [t.name for t in spec.tendons]
    if name not in known:
        raise UnknownNameError("tendon", name, known)
    for plugin in spec.plugins:
        if plugin.plugin_name == NAME and plugin.config.get("tendon") == name:
            raise InvalidValueError(f"tendon {name!r} already runs in sheath {plugin.name!r}")
    element = spec.tendon(name)
    if any(point.type != _SITE for point in element.path):
        raise InvalidValueError(
            f"tendon {name!r} does not run over sites alone, which is what a sheath needs: "
            "no joints, geoms or pulleys"
        )
    return element


def _parameter(name: str, value: SupportsFloat | None) -> float | None:
    """A parameter of the law as a number; None where the law allows it."""
    if value is None and not LAW[name].required and LAW[name].default is None:
        return None
    return as_number(name, value)


def _spool(
    spec: mujoco.MjSpec, end: str, joint: str | None, radius: SupportsFloat | None
) -> dict[str, str]:
    """Attributes of a spool at one end; none without one."""
    if joint is None and radius is None:
        return {}
    if joint is None or radius is None:
        raise InvalidValueError(f"{end}_joint and {end}_radius go together, one of them is missing")
    known = [j.name for j in spec.joints]
    if joint not in known:
        raise UnknownNameError("joint", joint, known, f"{end}_joint")
    arm = as_number(f"{end}_radius", radius)
    if not math.isfinite(arm) or arm == 0.0:
        raise InvalidValueError(f"{end}_radius = {arm:g} [m] must be finite and not 0")
    return {f"{end}_joint": joint, f"{end}_radius": repr(arm)}
