"""Gives tendons of a model sheaths with friction."""

from __future__ import annotations

import functools
import math
import warnings
from collections.abc import Iterable, Mapping, Sequence
from typing import Literal, NamedTuple, SupportsFloat, Unpack

import mujoco

from tendon_mj.attach.elasticity import constraints_on
from tendon_mj.attach.idlers import idlers
from tendon_mj.attach.instance import add_instance
from tendon_mj.attach.keywords import as_count, as_number, check_names, takes
from tendon_mj.attach.names import SheathNames, TakenNames
from tendon_mj.attach.sensor import Sensors, add_plugin_sensor, check_kinds
from tendon_mj.attach.sheath_design import Design, Request, design_sheath
from tendon_mj.attach.sheathed import actuators_by_tendon, force_on_tendon, sheaths_by_tendon
from tendon_mj.attach.spool import Spool, SpoolDesign, add_spools, design_spool, spool_names
from tendon_mj.attach.tendon_choice import Chosen, asks_for_several, check_spec, choose_tendons
from tendon_mj.attach.tendon_path import crossed_joints, idlers_are_possible, is_limited
from tendon_mj.errors import InvalidValueError, TendonWarning, UnknownNameError, UnsuitedTendonError
from tendon_mj.plugin import INPUT_ENDS, NAME, SPRINGS
from tendon_mj.sheath import LAW, OptionalParameters


class _Sheath(NamedTuple):
    tendon: mujoco.MjsTendon
    tendon_name: str
    design: Design
    spool: SpoolDesign | None


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
    output_joint: str | None = None,
    output_radius: float | None = None,
    spool: Spool | None = None,
    spring: Literal["cable", "input"] = "cable",
    sensors: Sequence[str] = ("input_tension", "output_tension"),
    **parameters: Unpack[OptionalParameters],
) -> mujoco.MjSpec:
    """Let spatial tendons run through sheaths with Coulomb friction.

    Where an actuator pulls a tendon, its force is the input tension; EA is then by default the
    stiffest that the step resolves, and there is no T_0. Elsewhere the tendon's own spring is the
    cable's elasticity: EA and T_0 default to its stiffness times its spring length and its pull at
    `qpos0`, and follow them where the model is changed later; a shorter spring length is tendon
    wound in at the input. The force of a spring that is not such a one (slack at `qpos0`, with a
    dead band, a polynomial, over pulleys) is the input tension. Where nothing but an equality or a
    limit (``range``) pulls the tendon, their force is.

    Args:
        spec: changed in place and returned; not at all where the call is refused.
        tendon: name of a spatial tendon; a list of names, which gives each tendon names that begin
            with its own; or a pattern with ``*``, ``?`` or ``[…]``.
            A pattern leaves out tendons that are fixed, run in a sheath or that nothing pulls, and
            names tendons that have no name; a warning says which.
        <parameters>
        arc_guides: guides on each geom that a tendon may wrap around.
        inner_guides: guides at the input end, for bend that is not drawn (``extra_bend``), as of a
            cable outside the model; by default one where there is no other, else none.
        input_end: site of the path, ``first`` or ``last``, at which a tendon is pulled or wound in.
            ``last`` is for one that is drawn from its insertion to its muscle or motor.
        name: of the sheath. By default that of a tendon asked for alone is ``sheath`` or, where
            that is taken, ``<tendon>_sheath``; of one among several always ``<tendon>_sheath``.
        reel: name of an actuator to add that winds tendon in at the input, control in metres.
            Without one, a sensor named like the sheath is added, which shows T_in and T_out.
        reel_joint, reel_radius: joint [rad] or slide whose motion winds tendon in, and radius [m].
        output_joint, output_radius: the same at the output end.
        spool: that the actuators of a tendon are to turn instead of pulling it: a body
            ``<tendon>_spool`` on a hinge of that name, at the input end and on its body. At rest
            their force is T_in + T_in²/2EA. ``axial_stiffness`` is required; T_0 is 0 by default,
            and ``axial_damping`` EA times the time step, against ringing.
        spring: what the tendon's own spring stands for: the ``cable``'s elasticity, or a spring at
            the ``input`` end, whose force is the input tension.
        sensors: kinds to add. Those of a tendon asked for alone are named like the kind, or
            ``<tendon>_<kind>`` where that is taken (``<name>_<kind>`` with a name); of one in a
            list, even of one tendon, always ``<tendon>_<kind>``.

    Returns:
        ``spec``.

    Raises:
        UnknownNameError: no such tendon, parameter or sensor kind, with the nearest name.
        InvalidValueError: a parameter outside its range, a tendon asked for by its name that cannot
            run in a sheath or already does, or a pattern that means no other; an actuator that
            would not pull through a spool as before, such as a muscle.

    Warns:
        TendonWarning: of tendons that were named, left out, or have nothing to rub on; of actuators
            that can push; of a side site that friction turns away from its tendon.
    """
    check_spec(spec)
    check_names(LAW, parameters, "add_friction")
    check_kinds(sensors)
    several = asks_for_several(spec, tendon)
    if several:
        own: dict[str, str | None] = {"name": name}
        alone = isinstance(tendon, list | tuple) and list(tendon) in [
            [t.name] for t in spec.tendons
        ]
        if not alone:
            own |= {"reel": reel, "reel_joint": reel_joint, "output_joint": output_joint}
        _refuse_for_several(own, tendon)
    if spring not in SPRINGS:
        raise UnknownNameError("spring", str(spring), SPRINGS, "add_friction")
    if input_end not in INPUT_ENDS:
        raise UnknownNameError("input_end", str(input_end), INPUT_ENDS, "add_friction")
    if spool is not None and (reel is not None or reel_joint is not None):
        raise InvalidValueError("give one of spool, reel and reel_joint, not more")
    if reel is not None and reel in [actuator.name for actuator in spec.actuators]:
        raise InvalidValueError(f"the model already has an actuator {reel!r}")
    ends = _spool(spec, "reel", reel_joint, reel_radius)
    ends |= _spool(spec, "output", output_joint, output_radius)
    law = {
        "friction": friction,
        "axial_stiffness": axial_stiffness,
        "pretension": pretension,
        **parameters,
    }
    request = Request(
        law=law,  # type: ignore[arg-type]
        arc_guides=as_count("arc_guides", arc_guides, 1),
        inner_guides=None if inner_guides is None else as_count("inner_guides", inner_guides, 0),
        input_end=input_end,
        ends=ends,
        is_wound=bool(ends) or reel is not None or spool is not None,
        is_wound_in=reel_joint is not None or reel is not None or spool is not None,
        spool=spool,
        spring=spring,
        timestep=float(spec.option.timestep),
    )
    taken = TakenNames(spec)
    if name is not None and not isinstance(name, str):
        raise InvalidValueError(f"name = {name!r} is no text")
    if name is not None and (not name or name in taken.instances):
        raise InvalidValueError(f"{name!r} cannot be the name of a plugin instance: empty or taken")
    chosen = choose_tendons(spec, tendon)
    sheaths, left_out = _design(spec, chosen, request)
    if not sheaths:
        raise InvalidValueError(
            f"none of the tendons that {_listed(tendon)} means can be given a sheath:"
            f" {_reasons(left_out)}"
        )
    side_sites = _of_side_sites(spec, sheaths)  # before anything is changed, as it is compiled
    unnamed = [sheath.tendon_name for sheath in sheaths if not sheath.tendon.name]
    spools = {sheath.tendon_name: sheath.spool for sheath in sheaths if sheath.spool}
    joints = spool_names(spec, spools)
    add_spools(spec, {joints[one]: design for one, design in spools.items()})
    spec.activate_plugin(NAME)
    shown = Sensors(spec)
    for sheath in sheaths:
        one = sheath.tendon_name
        given = taken.of_several(one, sensors) if several else taken.of_one(one, sensors, name)
        _add(spec, sheath, given, reel, joints.get(one), shown)
    pulling = actuators_by_tendon(spec)
    driven = [s for s in sheaths if s.design.is_driven and s.tendon_name in pulling]
    _say(
        unnamed,
        left_out,
        {s.tendon_name: s.design.idle for s in sheaths if s.design.idle},
        [
            *(design.warning for design in spools.values() if design.warning),
            *(f"tendon {s.tendon_name!r}: {s.design.passing}" for s in sheaths if s.design.passing),
            *_of_joints(spec, {s.tendon_name: crossed_joints(s.tendon) for s in driven}),
            *_of_pushes(driven, pulling),
            *side_sites,
        ],
    )
    return spec


def _refuse_for_several(own: Mapping[str, str | None], tendon: str | Sequence[str]) -> None:
    for keyword, value in own.items():
        if value is not None:
            raise InvalidValueError(
                f"{keyword} = {value!r} belongs to one tendon, and {_listed(tendon)} may mean "
                "several: call add_friction for each by its name"
            )


def _design(
    spec: mujoco.MjSpec, chosen: Sequence[Chosen], request: Request
) -> tuple[list[_Sheath], dict[str, str]]:
    """Sheaths to be added; tendons that a pattern leaves out → why.

    Raises:
        InvalidValueError: a tendon asked for by its name cannot have a sheath.
    """
    compiled = functools.cache(spec.compile)  # not a copy: it would drop what nothing refers to
    sheathed = sheaths_by_tendon(spec)
    actuators = actuators_by_tendon(spec)
    sheaths, left_out = [], {}
    for tendon, name, by_name in chosen:
        try:
            if name in sheathed:
                raise UnsuitedTendonError(
                    f"tendon {name!r} already runs in sheath {sheathed[name].name!r}"
                )
            pulling = actuators.get(name, [])
            constraints = constraints_on(spec, tendon)
            design = design_sheath(tendon, name, request, pulling, constraints, compiled)
            spool = None
            if request.spool is not None:
                stiffness = float(design.config["axial_stiffness"])
                strain = float(design.config["pretension"]) / stiffness
                at_last = request.input_end == "last"
                spool = design_spool(
                    spec, tendon, name, request.spool, at_last, stiffness, strain, pulling, compiled
                )
        except UnsuitedTendonError as error:
            if by_name:
                raise
            left_out[name] = str(error)
            continue
        sheaths.append(_Sheath(tendon, name, design, spool))
    return sheaths, left_out


def _add(
    spec: mujoco.MjSpec,
    sheath: _Sheath,
    names: SheathNames,
    reel: str | None,
    spool: str | None,
    shown: Sensors,
) -> None:
    """Add a sheath with what refers to it, without which `MjSpec.copy` and attach would lose it."""
    tendon = sheath.tendon_name
    sheath.tendon.name = tendon
    config = {"tendon": tendon, **sheath.design.config}
    if sheath.spool is not None and spool is not None:
        config |= {"reel_joint": spool, "reel_radius": repr(sheath.spool.radius)}
    plugin = add_instance(spec, names.sheath, config, NAME)
    if reel is None:
        add_plugin_sensor(spec, names.ends, tendon).plugin = plugin
    else:
        actuator = spec.add_actuator(name=reel, trntype=mujoco.mjtTrn.mjTRN_TENDON, target=tendon)
        actuator.plugin = plugin
    for kind, (sensor, instance) in names.sensors.items():
        shown.add(tendon, kind, sensor, instance)


def _say(
    unnamed: Sequence[str],
    left_out: Mapping[str, str],
    idle: Mapping[str, str],
    more: Sequence[str],
) -> None:
    """Warn of tendons that were named or left as they are, and of friction without effect."""
    said = []
    if unnamed:
        said.append(f"tendons without a name are now {_listed(unnamed)}")
    if left_out:
        said.append(f"left as they are: {_reasons(left_out)}")
    for why in dict.fromkeys(idle.values()):
        names = [name for name, reason in idle.items() if reason == why]
        said.append(f"friction can do nothing on {_listed(names)}, {why}")
    for one in [*said, *more]:
        warnings.warn(f"add_friction: {one}", TendonWarning, stacklevel=3)


def _of_joints(spec: mujoco.MjSpec, crossed: Mapping[str, Sequence[mujoco.MjsJoint]]) -> list[str]:
    """Warnings of joints that limit or sense what the actuators of driven tendons do there."""
    joints = {joint.name: joint for joints in crossed.values() for joint in joints}
    limited = [name for name, j in joints.items() if is_limited(j.actfrclimited, j.actfrcrange)]
    on = [t for t, ends in crossed.items() if any(j.name in limited for j in ends)]
    sensed = [
        sensor.name
        for sensor in spec.sensors
        if sensor.type == mujoco.mjtSensor.mjSENS_JOINTACTFRC and sensor.objname in joints
    ]
    said = []
    if limited:
        said.append(
            f"actuatorfrcrange of joint {_listed(limited)} limits what actuators do there, and the"
            f" sheath on {_listed(on)} rubs under their whole force: limit the tendon (its "
            "actuatorfrcrange) or the actuator (its forcerange) instead"
        )
    if sensed:
        said.append(
            f"sensor {_listed(sensed)} (jointactuatorfrc) reads what actuators do there as if"
            " nothing rubbed: add the joint's qfrc_passive, or read a torque sensor"
        )
    return said


def _of_pushes(
    driven: Sequence[_Sheath], pulling: Mapping[str, Sequence[mujoco.MjsActuator]]
) -> list[str]:
    """Warning of the driven tendons that an actuator can push, and of those that it cannot pull."""
    forces = {
        one.tendon_name: [
            force_on_tendon(a, one.tendon) or (-math.inf, 0.0) for a in pulling[one.tendon_name]
        ]
        for one in driven
    }
    pushed = [name for name, ranges in forces.items() if max(high for _, high in ranges) > 0.0]
    if not pushed:
        return []
    unpulled = [name for name in pushed if min(low for low, _ in forces[name]) >= 0.0]
    never = f"; on {_listed(unpulled)} it can only push: turn its sign" if unpulled else ""
    return [
        f"a cable cannot push, and an actuator can on {_listed(pushed)}: a push (a force above 0) "
        "passes the sheath without friction, and its input tension is 0 meanwhile. End the "
        f"actuator's forcerange or ctrlrange at 0, and pull with a force below 0{never}"
    ]


def _of_side_sites(spec: mujoco.MjSpec, sheaths: Sequence[_Sheath]) -> list[str]:
    """Warnings of the side sites that friction turns away from their tendon."""
    if not any(idlers_are_possible(sheath.tendon) for sheath in sheaths):
        return []
    model, ids = spec.compile(), {sheath.tendon.id: sheath.tendon_name for sheath in sheaths}
    return [
        f"side site {model.site(idler.side_site).name!r} of tendon {ids[idler.tendon]!r} turns "
        f"with geom {model.geom(idler.geom).name!r}, which friction turns on joint "
        f"{model.joint(idler.joint).name!r}, and carries the tendon off the geom: put the side "
        "site on the body that bears the joint"
        for idler in idlers(model)
        if idler.side_site >= 0 and idler.tendon in ids
    ]


def _reasons(left_out: Mapping[str, str]) -> str:
    """Tendons by the reason why they have no sheath."""
    by_reason: dict[str, list[str]] = {}
    for name, why in left_out.items():
        by_reason.setdefault(why.removeprefix(f"tendon {name!r} "), []).append(name)
    return "; ".join(f"{_listed(names)}: {why}" for why, names in by_reason.items())


def _listed(names: str | Iterable[str]) -> str:
    return ", ".join(map(repr, [names] if isinstance(names, str) else names))


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
