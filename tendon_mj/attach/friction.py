"""Gives a tendon of a model a sheath that rubs."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from typing import SupportsFloat

import mujoco

from tendon_mj.attach.elasticity import own_elasticity
from tendon_mj.attach.instance import add_instance
from tendon_mj.attach.sensor import add_sensor, check_kinds, free_name
from tendon_mj.engine import NAME
from tendon_mj.errors import InvalidValueError, UnknownNameError
from tendon_mj.sheath import Law

_SITE = mujoco.mjtWrap.mjWRAP_SITE


def add_friction(
    spec: mujoco.MjSpec,
    tendon: str,
    *,
    friction: float,
    axial_stiffness: float | None = None,
    pretension: float | None = None,
    static_friction: float | None = None,
    constant_friction: float = 0.0,
    axial_damping: float = 0.0,
    stribeck_friction: float = 0.0,
    stribeck_velocity: float = 0.0,
    viscous_friction: float = 0.0,
    direction_asymmetry: float = 0.0,
    friction_gradient: float = 0.0,
    friction_drift: float = 0.0,
    backlash: float = 0.0,
    stiffening: float = 0.0,
    creep: float = 0.0,
    creep_time: float = 0.0,
    sheath_compliance: float = 0.0,
    tendon_mass: float = 0.0,
    extra_bend: float = 0.0,
    name: str | None = None,
    reel: str | None = None,
    reel_joint: str | None = None,
    reel_radius: float | None = None,
    output_joint: str | None = None,
    output_radius: float | None = None,
    sensors: Sequence[str] = ("input_tension", "output_tension"),
) -> mujoco.MjSpec:
    """Let a spatial tendon run through a sheath with Coulomb friction.

    The tendon's own stiffness moves into the sheath: EA and T_0 default to what it had, and it is
    set to 0 on the tendon.

    Args:
        spec: changed in place and returned.
        tendon: name of a spatial tendon over sites; its first site is the input end.
        friction: μ_d, or μ where no ``static_friction`` is given [-].
        axial_stiffness: EA [N]; default: the tendon's stiffness times its spring length.
        pretension: T_0 at `qpos0` [N]; default: what the tendon's spring exerts there.
        static_friction: μ_s ≥ μ_d [-].
        constant_friction: tension-independent friction of the whole sheath [N].
        axial_damping: [N s].
        stribeck_friction, stribeck_velocity: Δμ added at rest [-], fading with v_s [m/s].
        viscous_friction: friction per sliding speed of the whole sheath [N s/m].
        direction_asymmetry: α, μ(1 + α) towards the input, μ(1 − α) to the output [-].
        friction_gradient: growth of μ per tendon drawn past a guide [1/m].
        friction_drift: growth of μ per time [1/s].
        backlash: play between the drive and the drum, as tendon [m].
        stiffening: κ in T = EA ε (1 + κ ε) [-].
        creep, creep_time: share χ of strain that comes later [-], in which time [s].
        sheath_compliance: by which the sheath's mount yields at the input [m/N].
        tendon_mass: of the tendon in the sheath [kg].
        extra_bend: that the drawn path does not show, over all guides [rad].
        name: of the sheath, default ``sheath`` or, where that is taken, ``<tendon>_sheath``.
        reel: name of an actuator to add that winds tendon in at the input, control in metres.
            Without one, a sensor named like the sheath is added, which shows T_in and T_out.
        reel_joint, reel_radius: joint [rad] or slide whose motion winds tendon in, and radius [m].
        output_joint, output_radius: the same at the output end.
        sensors: kinds to add, named like the kind, or ``<name>_<kind>`` where that is taken.

    Returns:
        ``spec``.

    Raises:
        UnknownNameError: no such tendon or sensor kind, with the nearest name.
        InvalidValueError: a parameter outside its range, or a second sheath on the tendon.
    """
    element = _find_tendon(spec, tendon)
    check_kinds(sensors)
    if axial_stiffness is None or pretension is None:
        own_stiffness, own_pretension = own_elasticity(spec, tendon)
        axial_stiffness = own_stiffness if axial_stiffness is None else axial_stiffness
        pretension = own_pretension if pretension is None else pretension
    law = Law(
        axial_stiffness=_number("axial_stiffness", axial_stiffness),
        friction=_number("friction", friction),
        static_friction=(
            None if static_friction is None else _number("static_friction", static_friction)
        ),
        constant_friction=_number("constant_friction", constant_friction),
        axial_damping=_number("axial_damping", axial_damping),
        pretension=_number("pretension", pretension),
        stribeck_friction=_number("stribeck_friction", stribeck_friction),
        stribeck_velocity=_number("stribeck_velocity", stribeck_velocity),
        viscous_friction=_number("viscous_friction", viscous_friction),
        direction_asymmetry=_number("direction_asymmetry", direction_asymmetry),
        friction_gradient=_number("friction_gradient", friction_gradient),
        friction_drift=_number("friction_drift", friction_drift),
        backlash=_number("backlash", backlash),
        stiffening=_number("stiffening", stiffening),
        creep=_number("creep", creep),
        creep_time=_number("creep_time", creep_time),
        sheath_compliance=_number("sheath_compliance", sheath_compliance),
        tendon_mass=_number("tendon_mass", tendon_mass),
        extra_bend=_number("extra_bend", extra_bend),
    )
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
    if reel is not None:
        actuator = spec.add_actuator(name=reel, trntype=mujoco.mjtTrn.mjTRN_TENDON, target=tendon)
        actuator.plugin = sheath
    else:  # something has to refer to the sheath, or MjSpec.copy and attach lose it
        ends = spec.add_sensor(
            name=free_name(spec, name, f"{name}_ends"), type=mujoco.mjtSensor.mjSENS_PLUGIN
        )
        ends.plugin = sheath
    for kind in sensors:
        add_sensor(spec, name, kind)
    return spec


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


def _number(name: str, value: SupportsFloat) -> float:
    try:
        return float(value)
    except (TypeError, ValueError):
        raise InvalidValueError(f"{name} = {value!r} is not a number") from None


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
    arm = _number(f"{end}_radius", radius)
    if not math.isfinite(arm) or arm == 0.0:
        raise InvalidValueError(f"{end}_radius = {arm:g} [m] must be finite and not 0")
    return {f"{end}_joint": joint, f"{end}_radius": repr(arm)}
