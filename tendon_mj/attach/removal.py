"""Takes sheaths off tendons again."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import Any

import mujoco

from tendon_mj.attach.instance import own_configs
from tendon_mj.attach.sheathed import instances, is_shared, sheaths_by_tendon
from tendon_mj.attach.spool import remove_spools, spools_by_tendon
from tendon_mj.attach.tendon_choice import check_spec, choose_tendons
from tendon_mj.errors import InvalidValueError
from tendon_mj.plugin import NAME, SERVO


def remove_friction(spec: mujoco.MjSpec, tendon: str | Sequence[str]) -> mujoco.MjSpec:
    """Take the sheaths off tendons, with their sensors and the reels and spools that wind them.

    A tendon gets its actuators back from a spool that `add_friction` added, so that the model
    compiles to what it was before.

    Args:
        spec: changed in place and returned; not at all where the call is refused.
        tendon: name, several names, or a pattern, of which tendons without a sheath are left out.

    Returns:
        ``spec``.

    Raises:
        UnknownNameError: no such tendon.
        InvalidValueError: a tendon asked for by its name runs in no sheath, or a servo, a sensor
            or whatever else needs what would go.
    """
    check_spec(spec)
    sheaths = sheaths_by_tendon(spec)
    chosen = choose_tendons(spec, tendon)
    for one in chosen:
        if one.by_name and one.name not in sheaths:
            raise InvalidValueError(f"tendon {one.name!r} runs in no sheath")
    removed = {one.name: one.element for one in chosen if one.name in sheaths}
    configs = {plugin.name: config for plugin, config in instances(spec) if plugin.name}
    actuators = [a for a in spec.actuators if _is_on(a, removed, configs)]
    _check_needed(spec, removed, {actuator.name for actuator in actuators})
    reel_joints = {c["tendon"]: c["reel_joint"] for c in configs.values() if c.get("reel_joint")}
    spools = spools_by_tendon(spec, {t: joint for t, joint in reel_joints.items() if t in removed})
    remove_spools(spec, spools)
    for element in [*actuators, *(s for s in spec.sensors if _is_on(s, removed, configs))]:
        spec.delete(element)  # an instance without a name goes with it
    used = {sensor.plugin.name for sensor in spec.sensors if sensor.plugin.active}
    for plugin in [p for p in spec.plugins if p.name in configs]:
        config = configs[plugin.name]
        if config.get("tendon") in removed or (is_shared(config) and plugin.name not in used):
            spec.delete(plugin)
    return spec


def _is_on(holder: Any, tendons: Collection[str], configs: dict[str, dict[str, str]]) -> bool:
    """Whether a sensor or an actuator belongs to a sheath on one of the tendons.

    It refers to an instance by name, or has one of its own without a name.
    """
    plugin = holder.plugin
    if not plugin.active or plugin.plugin_name not in ("", NAME):
        return False
    config = configs.get(plugin.name, {}) if plugin.name else plugin.config
    if is_shared(config):
        return holder.objtype == mujoco.mjtObj.mjOBJ_TENDON and holder.objname in tendons
    return config.get("tendon") in tendons


def _check_needed(spec: mujoco.MjSpec, tendons: Collection[str], reels: Collection[str]) -> None:
    """Refuse to take away what a servo or a sensor of the model's own refers to."""
    servos = own_configs(spec, SERVO)
    for plugin in spec.plugins:
        if plugin.plugin_name != SERVO:
            continue
        config = servos[plugin.name] if plugin.name else plugin.config
        if config.get("tendon") in tendons:
            raise InvalidValueError(
                f"a servo needs the sheath on tendon {config['tendon']!r}: delete its "
                "actuator and its plugin instance first"
            )
    for sensor in spec.sensors:
        if sensor.objtype == mujoco.mjtObj.mjOBJ_ACTUATOR and sensor.objname in reels:
            raise InvalidValueError(
                f"sensor {sensor.name!r} shows the reel {sensor.objname!r}, which would go with "
                "its sheath: delete the sensor first"
            )
