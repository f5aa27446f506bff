"""Gives a tendon of a model a sheath that rubs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import mujoco

from tendon_mj.engine import KINDS, NAME
from tendon_mj.errors import InvalidValueError, UnknownNameError
from tendon_mj.sheath import Law

_SITE = mujoco.mjtWrap.mjWRAP_SITE


def _own_elasticity(spec: mujoco.MjSpec, name: str) -> tuple[float, float]:
    """EA and T_0 [N] that a tendon's own stiffness and spring length amount to at `qpos0`."""
    tendon = spec.tendon(name)
    stiffness, spring = float(tendon.stiffness[0]), float(tendon.springlength[1])
    model = spec.compile()  # not a copy: MuJoCo's copies drop a plugin that no element refers to
    length = float(model.tendon_length0[model.tendon(name).id])
    if stiffness > 0.0 and spring == 0.0:
        raise InvalidValueError(
            f"tendon {name!r} has springlength = 0, so no strain is defined: give axial_stiffness "
            "and pretension"
        )
    unstretched = spring if spring > 0.0 else length
    return stiffness * unstretched, max(0.0, stiffness * (length - unstretched))


def _instance(spec: mujoco.MjSpec, name: str, config: dict[str, Any]) -> Any:
    taken = [plugin.name for plugin in spec.plugins]
    if name in taken:
        raise InvalidValueError(f"the model already has a plugin instance {name!r}")
    plugin = spec.add_plugin(name=name, plugin_name=NAME, active=True)
    plugin.config = {
        k: v if isinstance(v, str) else repr(v) for k, v in config.items() if v is not None
    }
    return plugin


def _check_kind(kind: str) -> None:
    if kind not in KINDS:
        raise UnknownNameError("sensor", kind, KINDS)


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
    known = [t.name for t in spec.tendons]
    if tendon not in known:
        raise UnknownNameError("tendon", tendon, known)
    for plugin in spec.plugins:
        if plugin.plugin_name == NAME and plugin.config.get("tendon") == tendon:
            raise InvalidValueError(f"tendon {tendon!r} already runs in sheath {plugin.name!r}")
    for kind in sensors:
        _check_kind(kind)
    element = spec.tendon(tendon)
    if any(point.type != _SITE for point in element.path):
        raise InvalidValueError(
            f"tendon {tendon!r} does not run over sites alone, which is what a sheath needs: "
            "no joints, geoms or pulleys"
        )
    if axial_stiffness is None or pretension is None:
        own_stiffness, own_pretension = _own_elasticity(spec, tendon)
        if axial_stiffness is None and not own_stiffness > 0.0:
            raise InvalidValueError(
                f"tendon {tendon!r} has no stiffness to take over: give axial_stiffness [N]"
            )
        axial_stiffness = own_stiffness if axial_stiffness is None else axial_stiffness
        pretension = own_pretension if pretension is None else pretension
    law = Law(
        axial_stiffness=axial_stiffness,
        friction=friction,
        static_friction=static_friction,
        constant_friction=constant_friction,
        axial_damping=axial_damping,
        pretension=pretension,
    )
    spec.activate_plugin(NAME)
    if name is None:
        name = "sheath"
        if name in [plugin.name for plugin in spec.plugins]:
            name = f"{tendon}_sheath"
    config = {
        "tendon": tendon,
        "axial_stiffness": law.axial_stiffness,
        "friction": law.friction,
        "static_friction": law.static_friction,
        "constant_friction": law.constant_friction or None,
        "axial_damping": law.axial_damping or None,
        "pretension": law.pretension,
        "reel_joint": reel_joint,
        "reel_radius": reel_radius,
        "output_joint": output_joint,
        "output_radius": output_radius,
        "guides": str(len(element.path) - 2),
    }
    sheath = _instance(spec, name, config)
    element.stiffness[:] = 0.0
    element.springlength[:] = -1.0
    if reel is not None:
        actuator = spec.add_actuator(name=reel, trntype=mujoco.mjtTrn.mjTRN_TENDON, target=tendon)
        actuator.plugin = sheath
    else:  # something has to refer to the sheath, or MjSpec.copy and attach lose it
        ends = spec.add_sensor(name=name, type=mujoco.mjtSensor.mjSENS_PLUGIN)
        ends.plugin = sheath
    for kind in sensors:
        add_sensor(spec, name, kind)
    return spec


def add_sensor(
    spec: mujoco.MjSpec, sheath: str, kind: str, name: str | None = None
) -> mujoco.MjsSensor:
    """Add a sensor that shows something of a sheath.

    Args:
        spec: changed in place.
        sheath: name of the plugin instance.
        kind: one of ``tendon_mj.engine.KINDS``.
        name: of the sensor; default: the kind, or ``<sheath>_<kind>`` where that is taken.

    Raises:
        UnknownNameError: no such sheath or kind.
    """
    sheaths = {
        p.name: p for p in spec.plugins if p.plugin_name == NAME and "sensor" not in p.config
    }
    if sheath not in sheaths:
        raise UnknownNameError("sheath", sheath, sheaths)
    _check_kind(kind)
    if name is None:
        taken = [s.name for s in spec.sensors]
        name = kind if kind not in taken else f"{sheath}_{kind}"
    view = _instance(
        spec, f"{sheath}.{kind}", {"tendon": sheaths[sheath].config["tendon"], "sensor": kind}
    )
    sensor = spec.add_sensor(name=name, type=mujoco.mjtSensor.mjSENS_PLUGIN)
    sensor.plugin = view
    return sensor
