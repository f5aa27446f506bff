"""Sheaths and actuators on the tendons of a spec."""

from __future__ import annotations

import math
from collections.abc import Mapping

import mujoco
import numpy as np

from tendon_mj.attach.instance import own_configs
from tendon_mj.attach.tendon_path import is_limited
from tendon_mj.plugin import NAME

_GAIN, _BIAS = mujoco.mjtGain, mujoco.mjtBias


def instances(spec: mujoco.MjSpec) -> list[tuple[mujoco.MjsPlugin, dict[str, str]]]:
    """Plugin instances of sheaths and of their sensors, each with its configuration.

    Names are those that the elements have now; of an instance without a name they are as written.
    """
    own = own_configs(spec, NAME)
    return [
        (plugin, own[plugin.name] if plugin.name else plugin.config)
        for plugin in spec.plugins
        if plugin.plugin_name == NAME
    ]


def sheaths_by_tendon(spec: mujoco.MjSpec) -> dict[str, mujoco.MjsPlugin]:
    """Tendon → the plugin instance of the sheath that it runs in."""
    return {c.get("tendon", ""): plugin for plugin, c in instances(spec) if "sensor" not in c}


def is_shared(config: Mapping[str, str]) -> bool:
    """Whether an instance is one of sensors that say by their object whose sheath they show."""
    return "sensor" in config and "tendon" not in config


def name_of(actuator: mujoco.MjsActuator) -> str:
    """An actuator for messages: its name, or its number where it has none."""
    return repr(actuator.name) if actuator.name else f"actuator {actuator.id}, which has no name"


def actuators_by_tendon(spec: mujoco.MjSpec) -> dict[str, list[mujoco.MjsActuator]]:
    """Tendon → the actuators on it."""
    found: dict[str, list[mujoco.MjsActuator]] = {}
    for actuator in spec.actuators:
        if actuator.trntype == mujoco.mjtTrn.mjTRN_TENDON:
            found.setdefault(actuator.target, []).append(actuator)
    return found


def force_on_tendon(
    actuator: mujoco.MjsActuator, tendon: mujoco.MjsTendon
) -> tuple[float, float] | None:
    """Least and largest force of an actuator on its tendon that its ranges allow [N].

    A pull is below 0, a push above. A servo without a range can do both; an actuator whose force is
    not a polynomial, such as a muscle, is taken to pull. None of a motor without a range, which
    says nothing of whether it is to push.
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
    if is_limited(tendon.actfrclimited, tendon.actfrcrange):
        force = force.clip(*tendon.actfrcrange)
    is_stated = is_stated or bool(force[1] <= 0.0)
    return (float(force[0]), float(force[1])) if is_stated else None
