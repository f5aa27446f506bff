"""Warnings of `add_friction`: tendons named or left out, and friction without its full effect."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence

import mujoco

from tendon_mj.attach import tendons
from tendon_mj.attach.sheath_design import NewSheath
from tendon_mj.attach.tendon_bend import idlers


def warnings_of(
    spec: mujoco.MjSpec,
    sheaths: Sequence[NewSheath],
    unnamed: Sequence[str],
    left_out: Mapping[str, str],
) -> list[str]:
    """Warnings of a call that has added its sheaths; ``left_out``: tendon → reason."""
    pulling = tendons.actuators_by_tendon(spec)
    driven = [s for s in sheaths if s.is_driven and s.name in pulling]
    messages = [f"tendons without a name are now {listed(unnamed)}"] if unnamed else []
    if left_out:
        messages.append(f"left as they are: {listed_reasons(left_out)}")
    idle: dict[str, list[str]] = {}
    for sheath in sheaths:
        if sheath.idle:
            idle.setdefault(sheath.idle, []).append(sheath.name)
    messages += [f"friction can do nothing on {listed(on)}, {why}" for why, on in idle.items()]
    messages += [s.spool.warning for s in sheaths if s.spool and s.spool.warning]
    messages += [f"tendon {s.name!r}: {s.passing}" for s in sheaths if s.passing]
    return messages + _joint_warnings(spec, driven) + _push_warnings(driven, pulling)


def _joint_warnings(spec: mujoco.MjSpec, driven: Sequence[NewSheath]) -> list[str]:
    """Warnings of joints that limit or sense the actuators of driven tendons."""
    crossed = {sheath.name: tendons.crossed_joints(sheath.tendon) for sheath in driven}
    joints = {joint.name: joint for joints in crossed.values() for joint in joints}
    limited = [
        name for name, j in joints.items() if tendons.is_limited(j.actfrclimited, j.actfrcrange)
    ]
    on = [t for t, ends in crossed.items() if any(j.name in limited for j in ends)]
    sensed = [
        sensor.name
        for sensor in spec.sensors
        if sensor.type == mujoco.mjtSensor.mjSENS_JOINTACTFRC and sensor.objname in joints
    ]
    messages = []
    if limited:
        messages.append(
            f"actuatorfrcrange of joint {listed(limited)} limits the actuators' force there, and"
            f" the sheath on {listed(on)} rubs under their whole force: limit the tendon (its "
            "actuatorfrcrange) or the actuator (its forcerange) instead"
        )
    if sensed:
        messages.append(
            f"sensor {listed(sensed)} (jointactuatorfrc) reads the actuators' force there as if"
            " nothing rubbed: add the joint's qfrc_passive, or read a torque sensor"
        )
    return messages


def _push_warnings(
    driven: Sequence[NewSheath], pulling: Mapping[str, Sequence[mujoco.MjsActuator]]
) -> list[str]:
    """Warning of the driven tendons that an actuator can push, and of those that it cannot pull."""
    forces = {
        s.name: [tendons.force_on_tendon(a, s.tendon) or (-math.inf, 0.0) for a in pulling[s.name]]
        for s in driven
    }
    pushed = [name for name, ranges in forces.items() if max(high for _, high in ranges) > 0.0]
    if not pushed:
        return []
    unpulled = [name for name in pushed if min(low for low, _ in forces[name]) >= 0.0]
    never = f"; on {listed(unpulled)} it can only push: turn its sign" if unpulled else ""
    return [
        f"a cable cannot push, and an actuator can on {listed(pushed)}: a push (a force above 0) "
        "passes the sheath without friction, and its input tension is 0 meanwhile. End the "
        f"actuator's forcerange or ctrlrange at 0, and pull with a force below 0{never}"
    ]


def side_site_warnings(spec: mujoco.MjSpec, sheaths: Sequence[NewSheath]) -> list[str]:
    """Warnings of side sites that friction turns away from their tendon; ``spec``: without it."""
    if not any(tendons.idlers_are_possible(sheath.tendon) for sheath in sheaths):
        return []
    model, ids = spec.compile(), {sheath.tendon.id: sheath.name for sheath in sheaths}
    return [
        f"side site {model.site(idler.side_site).name!r} of tendon {ids[idler.tendon]!r} turns "
        f"with geom {model.geom(idler.geom).name!r}, which friction turns on joint "
        f"{model.joint(idler.joint).name!r}, and carries the tendon off the geom: put the side "
        "site on the body that bears the joint"
        for idler in idlers(model)
        if idler.side_site >= 0 and idler.tendon in ids
    ]


def listed_reasons(left_out: Mapping[str, str]) -> str:
    """Tendons by the reason why they have no sheath."""
    by_reason: dict[str, list[str]] = {}
    for name, why in left_out.items():
        by_reason.setdefault(why.removeprefix(f"tendon {name!r} "), []).append(name)
    return "; ".join(f"{listed(names)}: {why}" for why, names in by_reason.items())


def listed(names: str | Iterable[str]) -> str:
    """A name, or several, in quotes."""
    return ", ".join(map(repr, [names] if isinstance(names, str) else names))
