"""Gives tendons of a model sheaths with friction, warns of limits of that, and takes them off."""

from __future__ import annotations

import math
import warnings
from collections.abc import Collection, Mapping, Sequence
from typing import Any, Literal, SupportsFloat, Unpack

import mujoco

from tendon_mj.attach import instances, tendons
from tendon_mj.attach.keyframes import restore_keyframes
from tendon_mj.attach.keywords import as_count, check_names, checked_number, one_of, takes
from tendon_mj.attach.motor import added_motors, remove_motors
from tendon_mj.attach.sheath_design import Designer, NewSheath, Request
from tendon_mj.attach.spool import Spool, add_spools, remove_spools
from tendon_mj.attach.tendon_bend import idlers
from tendon_mj.attach.tendons import asks_for_several, check_spec, choose_tendons, is_cable, listed
from tendon_mj.errors import InvalidValueError, TendonWarning, UnknownNameError
from tendon_mj.plugin import INPUT_ENDS, NAME, PARAMETERS, SERVO, SPRINGS
from tendon_mj.sheath import LAW, Law, OptionalParameters, check_in_range, doubt_of_unit

# EA and T_0, which then follow from the model, and parameters that are off
_MAY_BE_NONE = {
    *("axial_stiffness", "pretension"),
    *(name for name, known in LAW.items() if known.default is None and not known.required),
}


@takes(LAW)
def add_friction(
    spec: mujoco.MjSpec,
    tendon: str | Sequence[str],
    *,
    friction: float,
    axial_stiffness: float | None = None,
    pretension: float | None = None,
    arc_guides: int = 1,
    inner_guides: int | None = None,
    input_end: Literal["first", "last"] = "first",
    name: str | None = None,
    reel: str | None = None,
    reel_joint: str | None = None,
    reel_radius: float | None = None,
    reel_play: float = 0.0,
    output_joint: str | None = None,
    output_radius: float | None = None,
    output_play: float = 0.0,
    spool: Spool | None = None,
    spring: Literal["cable", "input"] = "cable",
    sensors: Sequence[str] = ("input_tension", "output_tension"),
    **parameters: Unpack[OptionalParameters],
) -> mujoco.MjSpec:
    """Let spatial tendons run through sheaths with Coulomb friction.

    If an actuator pulls a tendon, its force is the input tension; EA is then by default the
    stiffest that the step resolves, and there is no T_0. Elsewhere the tendon's own spring is the
    cable's elasticity: EA and T_0 default to its stiffness times its spring length and its pull at
    `qpos0`, and follow them where the model is changed later; a shorter spring length is tendon
    wound in at the input. The force of a spring that is not such a one (slack at `qpos0`, with a
    dead band, a polynomial, over pulleys) is the input tension. Where nothing but an equality or a
    limit (``range``) pulls the tendon, their force is.

    Args:
        spec: changed in place and returned; not at all if the call is refused.
        tendon: name of a spatial tendon; a list of names, so that the names of sheaths and sensors
            begin with the tendon's; or a pattern with ``*``, ``?`` or ``[…]``.
            A pattern leaves out tendons that are fixed, run in a sheath or that nothing pulls, and
            names tendons that have no name; a warning says which.
        <parameters>
        arc_guides: guides on each geom that a tendon may wrap around.
        inner_guides: guides at the input end, for bend that is not drawn (``extra_bend``), as of a
            cable outside the model; by default one if there is no other, else none.
        input_end: site of the path, ``first`` or ``last``, at which a tendon is pulled or wound in.
            ``last`` is for one that is drawn from its insertion to its muscle or motor.
        name: of the sheath, by default ``<tendon>_sheath``.
        reel: name of an actuator to add that winds tendon in at the input, control in metres.
            Without one, a sensor named like the sheath is added, which shows T_in and T_out.
        reel_joint, reel_radius: joint [rad] or slide that winds tendon in, and radius [m].
        reel_play: play between that joint and the drum, of all cables that it winds [rad or m].
        output_joint, output_radius, output_play: the same at the output end.
        spool: that the actuators of a tendon are to turn instead of pulling it: a body
            ``<tendon>_spool`` on a hinge of that name, at the input end and on its body. At rest
            their force is T_in + T_in²/2EA. ``axial_stiffness`` is required; T_0 is 0 by default,
            and ``axial_damping`` EA times the time step, against ringing.
        spring: role of the tendon's own spring: the ``cable``'s elasticity, or a spring at the
            ``input`` end, whose force is the input tension.
        sensors: kinds to add. Those of a tendon given alone are named like the kind, or
            ``<tendon>_<kind>`` if that is taken (``<name>_<kind>`` with a name); of one in a
            list, even of one tendon, always ``<tendon>_<kind>``.

    Returns:
        ``spec``.

    Raises:
        UnknownNameError: no such tendon, parameter or sensor kind, with the nearest name.
        InvalidValueError: a parameter outside its range, a tendon given by its name that cannot
            run in a sheath or already does, or a pattern that means no other; an actuator that
            would not pull through a spool as before, such as a muscle.

    Warns:
        TendonWarning: of a friction above 2 or a bend above four turns; of tendons that were named,
            left out, or have nothing to rub on; of actuators that can push; of a side site that
            friction turns away from its tendon; of an axial stiffness that the time step of the
            model does not carry.
    """
    check_spec(spec)
    check_names(LAW, parameters, "add_friction")
    instances.check_kinds(sensors)
    several = asks_for_several(spec, tendon)
    if several:
        ends = {"reel": reel, "reel_joint": reel_joint, "output_joint": output_joint}
        _refuse_for_several(spec, tendon, name, ends)
    _check_reel(spec, reel, reel_joint, spool)
    drums = _end_attributes(spec, "reel", reel_joint, reel_radius, reel_play)
    drums |= _end_attributes(spec, "output", output_joint, output_radius, output_play)
    is_wound_in = any(given is not None for given in (reel_joint, reel, spool))
    numbers: dict[str, Any] = {"axial_stiffness": axial_stiffness, "pretension": pretension}
    numbers |= {"friction": friction, **parameters}
    request = Request(
        *_law(spec, spool, numbers),
        arc_guides=as_count("arc_guides", arc_guides, 1),
        inner_guides=None if inner_guides is None else as_count("inner_guides", inner_guides, 0),
        input_end=one_of("input_end", input_end, INPUT_ENDS, "add_friction"),
        ends=drums,
        is_wound=bool(drums) or is_wound_in,
        is_wound_in=is_wound_in,
        spool=spool,
        spring=one_of("spring", spring, SPRINGS, "add_friction"),
    )
    if name is not None:
        instances.check_instance_name(name, instances.taken_names(spec)[0])
    sheaths, left_out = Designer(spec, request).design_all(choose_tendons(spec, tendon))
    if not sheaths:
        raise InvalidValueError(
            f"none of the tendons matching {listed(tendon)} can be given a sheath:"
            f" {listed_reasons(left_out)}"
        )
    side_sites = side_site_warnings(spec, sheaths)
    unnamed = [sheath.name for sheath in sheaths if not sheath.tendon.name]
    add_sheaths(spec, sheaths, name, reel, sensors, alone=not several)
    doubts = [doubt_of_unit(key, value) for key, value in numbers.items() if value is not None]
    messages = warnings_of(spec, sheaths, unnamed, left_out)
    for message in filter(None, [*doubts, *messages, *side_sites]):
        warnings.warn(f"add_friction: {message}", TendonWarning, stacklevel=2)
    return spec


def _refuse_for_several(
    spec: mujoco.MjSpec,
    tendon: str | Sequence[str],
    name: str | None,
    ends: Mapping[str, str | None],
) -> None:
    """Refuse arguments that belong to one tendon; a list of one name may have its own ends."""
    one = [[element.name] for element in spec.tendons]
    is_one = isinstance(tendon, list | tuple) and list(tendon) in one
    for keyword, value in {"name": name, **({} if is_one else ends)}.items():
        if value is not None:
            raise InvalidValueError(
                f"{keyword} = {value!r} belongs to one tendon, and {listed(tendon)} may mean "
                "several: call add_friction for each by its name"
            )


def _check_reel(
    spec: mujoco.MjSpec, reel: str | None, reel_joint: str | None, spool: Spool | None
) -> None:
    if spool is not None and (reel is not None or reel_joint is not None):
        raise InvalidValueError("give one of spool, reel and reel_joint, not more")
    if reel is not None and reel in [actuator.name for actuator in spec.actuators]:
        raise InvalidValueError(f"the model already has an actuator {reel!r}")


def _end_attributes(
    spec: mujoco.MjSpec,
    end: str,
    joint: str | None,
    radius: SupportsFloat | None,
    play: SupportsFloat,
) -> dict[str, str]:
    """Attributes of the joint that winds a tendon in or out at one end; none without one."""
    width = checked_number(f"{end}_play", play)
    check_in_range(PARAMETERS, f"{end}_play", width)
    if width and joint is None:
        raise InvalidValueError(f"{end}_play and {end}_joint go together, one of them is missing")
    if joint is None and radius is None:
        return {}
    if joint is None or radius is None:
        raise InvalidValueError(f"{end}_joint and {end}_radius go together, one of them is missing")
    known = [j.name for j in spec.joints]
    if joint not in known:
        raise UnknownNameError("joint", joint, known, f"{end}_joint")
    arm = checked_number(f"{end}_radius", radius)
    if not math.isfinite(arm) or arm == 0.0:
        raise InvalidValueError(f"{end}_radius = {arm:g} [m] must be finite and not 0")
    wound = {f"{end}_joint": joint, f"{end}_radius": repr(arm)}
    return wound | ({f"{end}_play": repr(width)} if width else {})


def _law(
    spec: mujoco.MjSpec, spool: Spool | None, given: Mapping[str, Any]
) -> tuple[Law, float | None, float | None]:
    """The law of the sheaths, and EA and T_0 where they are given."""
    values = {
        key: checked_number(key, value)
        for key, value in given.items()
        if value is not None or key not in _MAY_BE_NONE
    }
    if spool is not None:
        if "axial_stiffness" not in values:
            raise InvalidValueError("a spool needs axial_stiffness [N]")
        damping = values["axial_stiffness"] * float(spec.option.timestep)
        values = {"axial_damping": damping} | values
        if not values.get("slack"):
            values.setdefault("pretension", 0.0)
    law = Law(**{"axial_stiffness": 1.0, "pretension": 0.0} | values)
    return law, values.get("axial_stiffness"), values.get("pretension")


def add_sheaths(
    spec: mujoco.MjSpec,
    sheaths: Sequence[NewSheath],
    name: str | None,
    reel: str | None,
    kinds: Sequence[str],
    *,
    alone: bool,
) -> None:
    """Add sheaths and sensors or reels, without which `MjSpec.copy` and `attach` lose them.

    The tendon of one ``alone`` was given by its name, not among several.
    """
    take, (taken, sensors) = instances.take_name, instances.taken_names(spec)
    joints = add_spools(spec, [sheath.spool for sheath in sheaths if sheath.spool])
    spec.activate_plugin(NAME)
    for sheath in sheaths:
        tendon = sheath.tendon.name = sheath.name
        own = take(taken, f"{tendon}_sheath") if name is None else name
        ends = take(sensors, own, f"{own}_ends")
        config = {"tendon": tendon, **sheath.config}
        if sheath.spool is not None:
            config |= {"reel_joint": joints[tendon], "reel_radius": repr(sheath.spool.radius)}
        plugin = instances.add_instance(spec, own, config, NAME)
        if reel is None:
            instances.add_plugin_sensor(spec, ends, tendon).plugin = plugin
        else:
            on = {"trntype": mujoco.mjtTrn.mjTRN_TENDON, "target": tendon}
            spec.add_actuator(name=reel, **on).plugin = plugin
        for kind in kinds:
            short, prefix = (kind,) if alone else (), tendon if name is None else name
            sensor = take(sensors, *short, f"{prefix}_{kind}")
            instances.add_sensor_of(spec, config, kind, sensor, take(taken, f"{own}.{kind}"))


def remove_friction(spec: mujoco.MjSpec, tendon: str | Sequence[str]) -> mujoco.MjSpec:
    """Take the sheaths off tendons, with their sensors and the reels and spools that wind them.

    A tendon gets its actuators back from a spool that `add_friction` added, so that the model
    compiles to the same model as before.

    Args:
        spec: changed in place and returned; not at all if the call is refused.
        tendon: name, several names, or a pattern, of which tendons without a sheath are left out.

    Returns:
        ``spec``.

    Raises:
        UnknownNameError: no such tendon.
        InvalidValueError: a tendon given by its name runs in no sheath, or a servo, a sensor
            or another element needs a part that would go.
    """
    check_spec(spec)
    removed = _sheathed(spec, tendon)
    configs = {plugin.name: config for plugin, config in instances.instances(spec) if plugin.name}
    actuators, sensors = (
        [holder for holder in holders if _is_on(holder, removed, configs)]
        for holders in (spec.actuators, spec.sensors)
    )
    on_removed = [c for c in configs.values() if c.get("tendon") in removed]
    _check_needed(spec, on_removed, actuators)
    motors = added_motors(spec, removed)
    keys = remove_spools(
        spec, {c["tendon"]: c["reel_joint"] for c in on_removed if "reel_joint" in c}
    )
    cables = [tendon for tendon in map(spec.tendon, sorted(removed)) if is_cable(spec, tendon)]
    for holder in [*actuators, *sensors]:
        if not holder.plugin.name:  # an instance that goes with it by itself from MuJoCo 3.16 on
            spec.delete(holder.plugin)
        spec.delete(holder)
    _delete_instances(spec, removed, configs)
    for cable in cables:
        spec.delete(cable)
    if keys:
        restore_keyframes(spec, keys)
    remove_motors(spec, motors)
    return spec


def _sheathed(spec: mujoco.MjSpec, tendon: str | Sequence[str]) -> set[str]:
    """Tendons with a sheath among those that are chosen."""
    sheaths, chosen = instances.sheaths_by_tendon(spec), choose_tendons(spec, tendon)
    for element in chosen:
        if element.by_name and element.name not in sheaths:
            raise InvalidValueError(f"tendon {element.name!r} runs in no sheath")
    return {element.name for element in chosen} & set(sheaths)


def _delete_instances(
    spec: mujoco.MjSpec, tendons: Collection[str], configs: Mapping[str, Mapping[str, str]]
) -> None:
    """Delete instances of sheaths on tendons, and shared ones that no sensor uses now."""
    used = {sensor.plugin.name for sensor in spec.sensors if sensor.plugin.active}
    for plugin in list(spec.plugins):
        config = configs.get(plugin.name, {})
        if config.get("tendon") in tendons or (
            instances.is_shared(config) and plugin.name not in used
        ):
            spec.delete(plugin)


def _is_on(holder: Any, tendons: Collection[str], configs: Mapping[str, Mapping[str, str]]) -> bool:
    """Return whether a sensor or an actuator belongs to a sheath on one of the tendons.

    It refers to an instance by name, or has its own without a name.
    """
    plugin = holder.plugin
    if not plugin.active or plugin.plugin_name not in ("", NAME):
        return False
    config = configs.get(plugin.name, {}) if plugin.name else plugin.config
    if instances.is_shared(config):
        return holder.objtype == mujoco.mjtObj.mjOBJ_TENDON and holder.objname in tendons
    return config.get("tendon") in tendons


def _check_needed(
    spec: mujoco.MjSpec, configs: list[dict[str, str]], actuators: Sequence[mujoco.MjsActuator]
) -> None:
    """Refuse to take away an element that a servo or a sensor of the model's own refers to."""
    winding = {c["reel_joint"]: c["tendon"] for c in configs if "reel_joint" in c}
    servos = {plugin.name for plugin in spec.plugins if plugin.plugin_name == SERVO}
    for actuator in spec.actuators:
        if actuator.plugin.name in servos and actuator.target in winding:
            raise InvalidValueError(
                f"a servo needs the sheath on tendon {winding[actuator.target]!r}: delete its "
                "actuator and its plugin instance first"
            )
    reels = {actuator.name for actuator in actuators}
    for sensor in spec.sensors:
        if sensor.objtype == mujoco.mjtObj.mjOBJ_ACTUATOR and sensor.objname in reels:
            raise InvalidValueError(
                f"sensor {sensor.name!r} shows the reel {sensor.objname!r}, which would go with "
                "its sheath: delete the sensor first"
            )


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
    messages += [f"friction has no effect on {listed(on)}, {why}" for why, on in idle.items()]
    messages += [s.spool.warning for s in sheaths if s.spool and s.spool.warning]
    messages += [f"tendon {s.name!r}: {s.passing}" for s in sheaths if s.passing]
    messages += [f"tendon {s.name!r}: {s.too_stiff}" for s in sheaths if s.too_stiff]
    return messages + joint_warnings(spec, driven) + _push_warnings(driven, pulling)


def joint_warnings(spec: mujoco.MjSpec, driven: Sequence[NewSheath]) -> list[str]:
    """Warnings of joints that limit or sense the actuators of driven tendons."""
    crossed = {sheath.name: tendons.crossed_joints(sheath.tendon) for sheath in driven}
    joints = {joint.name: joint for joints in crossed.values() for joint in joints}
    limited = [
        name for name, j in joints.items() if tendons.is_limited(j.actfrclimited, j.actfrcrange)
    ]
    on = [t for t, ends in crossed.items() if any(j.name in limited for j in ends)]
    sensed = tendons.force_sensors(spec, joints)
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
        s.name: [tendons.force_range(a, s.tendon) or (-math.inf, 0.0) for a in pulling[s.name]]
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
