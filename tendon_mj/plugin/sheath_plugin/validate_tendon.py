"""Checks of a sheath's tendon while MuJoCo compiles the model: its drive, path and bodies.

MuJoCo neither computes the path of a tendon whose bodies sleep, nor wakes them for a plugin's
forces: a sheath would act with the path of the moment when they fell asleep, or not at all. Sheaths
on bodies that may fall asleep are refused.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Mapping, Sequence
from typing import Final, NamedTuple

import mujoco

from tendon_mj.errors import InvalidValueError
from tendon_mj.plugin.abi.checks import Draft
from tendon_mj.plugin.abi.library import C
from tendon_mj.plugin.sheath_plugin.fixed_tendon import is_fixed
from tendon_mj.plugin.sheath_plugin.input_force import acts_on, is_constrained
from tendon_mj.plugin.sheath_plugin.names import own_config
from tendon_mj.plugin.sheath_plugin.path import count_guides

_OBJ, _WRAP, _POLICY = mujoco.mjtObj, mujoco.mjtWrap, mujoco.mjtSleepPolicy
_SITE, _PULLEY = _WRAP.mjWRAP_SITE.value, _WRAP.mjWRAP_PULLEY.value
_GEOMS = (_WRAP.mjWRAP_SPHERE.value, _WRAP.mjWRAP_CYLINDER.value)
_NEVER = (_POLICY.mjSLEEP_NEVER.value, _POLICY.mjSLEEP_AUTO_NEVER.value)
UNDRAWN = ("extra_bend", "constant_friction")  # friction that is not where the path bends
_JOINTS = ("reel_joint", "output_joint")
# Parameters that a sheath whose input tension is given has no use for.
_LENGTHS = ("pretension", "slack")
_OF_A_SHEATH = ("backlash", "sheath_compliance", "viscous_friction", "tendon_mass")
_OF_A_REEL = (*_LENGTHS, *_OF_A_SHEATH)
_GIVEN = (
    "has no meaning where an actuator, a spring, an equality or a limit gives the input tension of"
    " tendon {!r}"
)
_ELASTICITY = ("axial_stiffness", "axial_damping", "stiffening", "creep")
_OF_ELASTICITY = (*_ELASTICITY, "creep_time")
_OF_A_PATH = (*_OF_ELASTICITY, "slack", *_OF_A_SHEATH)
_INEXTENSIBLE = (
    "has no meaning where tendon {!r} does not stretch: give it axial_stiffness in the model"
)
_NOT_DRAWN = "has no meaning on tendon {!r}, which is fixed: its cable is not drawn"
_NO_ACTUATOR = (
    "is a fixed tendon, and no actuator acts on it, or on its one joint: give an actuator a cable "
    "by tendon_mj.add_cable_drive"
)
_DRAWN = "has no meaning on a tendon that is drawn"
# Attributes that are read here.
DRIVE: Final = (*_JOINTS, "radius", "spring", *_ELASTICITY, *_OF_A_REEL)


class Drive(NamedTuple):
    """Drive of a tendon."""

    is_fixed: bool  # whether its cable is not drawn
    is_wound: bool  # by a reel or a joint
    is_cable: bool  # whether its own spring is the cable's elasticity
    spring: tuple[float, ...]  # coefficients of its own spring, lowest order first
    spring_range: tuple[float, float]  # lengths between which that is slack [m]
    pullers: list[int]  # actuators that pull on it as a whole
    is_constrained: bool  # whether an equality or a limit pulls it, and its length is not stated

    @property
    def is_given(self) -> bool:
        """Whether MuJoCo's forces along the tendon give the input tension."""
        pulled = any(self.spring) or bool(self.pullers) or self.is_constrained
        return pulled and not (self.is_wound or self.is_cable)

    @property
    def is_linear(self) -> bool:
        """Whether its own spring is positive and linear from one rest length on."""
        shortest, longest = self.spring_range
        is_plain = self.spring[0] > 0.0 and not any(self.spring[1:])
        return is_plain and longest > 0.0 and not 0.0 < shortest < longest


def read_drive(model: Draft, config: Mapping[str, str], tendon: int, reels: Sequence[int]) -> Drive:
    """Drive of a tendon whose sheath has these reels."""
    fixed = is_fixed(model, tendon)
    return Drive(
        is_fixed=fixed,
        is_wound=bool(reels) or any(config[joint] for joint in _JOINTS),
        is_cable=config["spring"] == "cable",
        spring=(model.tendon_stiffness[tendon], *model.tendon_stiffnesspoly[tendon]),
        spring_range=tuple(model.tendon_lengthspring[tendon]),
        pullers=[k for k in _on_tendon(model, tendon) if k not in reels],
        is_constrained=not (fixed or any(config[name] for name in _LENGTHS))
        and is_constrained(model, tendon),
    )


def unused_parameters(model: mujoco.MjModel, instance: int) -> dict[str, str]:
    """Parameters that a sheath has no use for, whatever their values, and why each has none."""
    draft = Draft(model._address, ("tendon", *DRIVE))
    config, reels = own_config(draft, instance), draft.actuators().get(instance, [])
    unused = {
        f"{joint.removesuffix('_joint')}_radius": f"has no meaning without {joint}"
        for joint in _JOINTS
        if not config[joint]
    }
    drive = read_drive(draft, config, draft.tendons[config["tendon"]], reels)
    if drive.is_fixed:
        return unused | dict.fromkeys(_OF_A_PATH, _NOT_DRAWN.format(config["tendon"]))
    unused["radius"] = _DRAWN
    if drive.is_given:
        unused |= dict.fromkeys(_OF_A_REEL, _GIVEN.format(config["tendon"]))
        if not any(float(config[name] or 0.0) for name in _ELASTICITY):
            unused |= dict.fromkeys(_OF_ELASTICITY, _INEXTENSIBLE.format(config["tendon"]))
    return unused


def check_drive(config: Mapping[str, str], drive: Drive, where: str, tendon: str) -> None:
    """Check that the parameters go with the tendon's drive.

    Raises:
        InvalidValueError: one that is missing, or has no meaning.
    """
    if drive.is_fixed:
        _check_fixed(config, drive, where, tendon)
        return
    if config["radius"]:
        raise InvalidValueError(f"{where}: radius = {config['radius']} {_DRAWN}; remove it")
    given = bool(config["axial_stiffness"])
    if not (given or drive.is_given or drive.is_cable):
        raise InvalidValueError(
            f"{where}: axial_stiffness is missing (its unit is N); only a tendon that an actuator, "
            "a spring of its own, an equality or a limit pulls on does without"
        )
    if drive.is_cable and not (given or drive.is_linear):
        shortest, longest = drive.spring_range
        raise InvalidValueError(
            f"{where}: spring = cable, and tendon {tendon!r} has the stiffness "
            f"{' '.join(f'{k:g}' for k in drive.spring)} and springlength {shortest:g} "
            f"{longest:g} [m]; a cable's stiffness is positive and linear from one rest length "
            "on: give it such ones, or axial_stiffness [N]"
        )
    useless = [k for k in _OF_A_REEL if drive.is_given and config[k] and float(config[k]) != 0.0]
    if useless:
        raise InvalidValueError(
            f"{where}: {useless[0]} = {config[useless[0]]} {_GIVEN.format(tendon)}; remove it, or "
            "wind the tendon in by a reel or a reel_joint"
        )


def _check_fixed(config: Mapping[str, str], drive: Drive, where: str, tendon: str) -> None:
    """Check the parameters of a fixed tendon, whose cable is not drawn."""
    if not drive.pullers:
        raise InvalidValueError(f"{where}: tendon {tendon!r} {_NO_ACTUATOR}")
    if not config["radius"] or config["inner_guides"] != "1":
        raise InvalidValueError(
            f"{where}: tendon {tendon!r} is fixed, with radius = {config['radius'] or None} and "
            f"inner_guides = {config['inner_guides'] or None}: give its drum's radius [m], and "
            "inner_guides = 1 for the bend of its cable, extra_bend [rad]"
        )
    useless = [name for name in _JOINTS if config[name]] + ["spring"] * drive.is_cable
    useless += [name for name in _OF_A_PATH if name in config and float(config[name] or 0.0)]
    if useless:
        raise InvalidValueError(
            f"{where}: {useless[0]} = {config[useless[0]]} {_NOT_DRAWN.format(tendon)}; remove it"
        )


def check_alone(model: Draft, drive: Drive, where: str, tendon: str) -> None:
    """Check that nothing else pulls on a tendon that is wound in, or that is its own spring.

    Raises:
        InvalidValueError: a spring of the tendon's own, or an actuator on it.
    """
    if drive.is_wound and any(drive.spring) and not drive.is_cable:
        raise InvalidValueError(
            f"{where}: tendon {tendon!r} has a stiffness of its own, "
            f"{' '.join(f'{k:g}' for k in drive.spring)}, which would "
            "act besides the sheath's axial_stiffness; remove it, or write spring = cable"
        )
    if drive.is_cable and not drive.is_wound and drive.pullers:
        names = ", ".join(repr(model.name(_OBJ.mjOBJ_ACTUATOR, k)) for k in drive.pullers)
        raise InvalidValueError(
            f"{where}: spring = cable, and actuator {names} pulls on tendon {tendon!r} as a whole; "
            "write spring = input, so that both forces are its input tension"
        )
    if drive.is_wound and drive.pullers:
        names = ", ".join(repr(model.name(_OBJ.mjOBJ_ACTUATOR, k)) for k in drive.pullers)
        raise InvalidValueError(
            f"{where}: actuator {names} pulls on tendon {tendon!r} as a whole, past the reel that "
            "winds it; remove one of them"
        )


def check_elastic(model: Draft, tendon: int, where: str, name: str) -> None:
    """Refuse a tendon whose own spring yields, as it may from MuJoCo 4 on.

    Raises:
        InvalidValueError: names the tendon and the force at which it does.
    """
    if not hasattr(model, "tendon_springyield"):
        return
    limit = model.tendon_springyield[tendon]
    if limit > 0.0:
        raise InvalidValueError(
            f"{where}: tendon {name!r} has springyield = {limit:g} N, and a sheath does not follow "
            "a spring that stays deformed; set it to 0"
        )


def _on_tendon(model: Draft, tendon: int) -> list[int]:
    """Actuators that act on a tendon but servos, which their own plugin checks."""
    owners = model.actuator_plugin
    return [
        k
        for k in range(model.nactuator)
        if acts_on(model, k, tendon)
        and (owners[k] < 0 or model.plugin_name(owners[k]) != "tendon_mj.servo")
    ]


def check_reels(
    model: Draft, instance: int, config: Mapping[str, str], reels: Sequence[int]
) -> None:
    """Check that there is one reel at most, on the sheath and on its tendon.

    Raises:
        InvalidValueError: several, or one elsewhere.
    """
    names = ", ".join(repr(model.name(_OBJ.mjOBJ_ACTUATOR, k)) for k in reels)
    if config["sensor"] and reels:
        raise InvalidValueError(
            f"{model.where(instance)}: actuator {names} belongs on the sheath's instance, not on "
            "that of a sensor"
        )
    if len(reels) > 1:
        raise InvalidValueError(
            f"{model.where(instance)}: a sheath has one reel, not {len(reels)}: {names}"
        )
    for reel in reels:
        if model.actuator_trntype[reel] != mujoco.mjtTrn.mjTRN_TENDON.value:
            continue
        target = model.name(_OBJ.mjOBJ_TENDON, model.actuator_trnid[reel, 0])
        if target != config["tendon"]:
            raise InvalidValueError(
                f"{model.where(instance)}: reel {names} acts on tendon {target!r}, the sheath "
                f"on {config['tendon']!r}"
            )


def kinds_on(model: Draft, tendon: int) -> list[int]:
    """Kinds of the elements on a tendon's path, as `mjtWrap` has them."""
    start, count = model.tendon_adr[tendon], model.tendon_num[tendon]
    return model.wrap_type[start : start + count].tolist()


def unsuited(kinds: Sequence[int], driven: bool) -> str:
    """Why a tendon with such elements on its path cannot run in a sheath; empty if it can."""
    if _PULLEY in kinds and not driven:
        return (
            "branches at a pulley, which only a tendon that an actuator pulls on may; give each "
            "branch a tendon of its own"
        )
    if _PULLEY in (kinds[0], kinds[-1]) or any(
        kind == following == _PULLEY for kind, following in itertools.pairwise(kinds)
    ):
        return "has a pulley without a branch before and behind it"
    return ""


def misplaced_input(model: Draft, tendon: int, input_end: str) -> str:
    """Why a tendon cannot have its input at this end; empty if it can."""
    kinds = kinds_on(model, tendon)
    if input_end != "last" or _PULLEY not in kinds:
        return ""
    element = model.tendon_adr[tendon] + kinds.index(_PULLEY) - 1
    site = model.name(_OBJ.mjOBJ_SITE, model.wrap_objid[element])
    return (
        f"branches at a pulley, behind its site {site!r}, and every branch has its input where it "
        "begins: leave out input_end = last and draw each branch from its input on, or give each "
        "a tendon of its own"
    )


def check_counts(model: Draft, config: Mapping[str, str], index: int, where: str) -> None:
    """Check that the counts, where they are given, are those of the path of a tendon."""
    tendon, arc_guides = config["tendon"], int(config["arc_guides"] or 1)
    inner_guides = int(config["inner_guides"] or 0)
    guides, arcs, pulleys = count_guides(model, index, arc_guides, inner_guides)
    if config["guides"] and int(config["guides"]) != guides:
        raise InvalidValueError(
            f"{where}: guides = {config['guides']}, but tendon {tendon!r} runs over {guides} "
            "between its ends; remove the attribute or correct it"
        )
    if arcs and guides == arcs * arc_guides + pulleys:
        for name in (k for k in UNDRAWN if config[k] and float(config[k]) != 0.0):
            raise InvalidValueError(
                f"{where}: {name} = {config[name]} is shared by guides at sites, as the tendon may "
                f"leave a geom, and tendon {tendon!r} has none: give inner_guides"
            )
    if arcs and config["guides"] and not config["arc_guides"]:
        raise InvalidValueError(
            f"{where}: tendon {tendon!r} wraps around geoms: beside guides, arc_guides has to be "
            "given too, the number of guides on each of them"
        )


def sleeps(model: Draft) -> bool:
    """Whether a model lets bodies fall asleep."""
    return bool(model.opt.enableflags & mujoco.mjtEnableBit.mjENBL_SLEEP.value)


def check_awake(model: Draft, tendon: int, spools: Iterable[str], where: str) -> None:
    """Refuse a tendon with a body on its path or a joint of a spool that may fall asleep.

    Raises:
        InvalidValueError: names the tendon, the body and the remedy.
    """
    bodies = []
    for name in filter(None, spools):
        joint = C.mj_name2id(model.address, _OBJ.mjOBJ_JOINT.value, name.encode())
        bodies.append(model.jnt_bodyid[joint])
    start, count = model.tendon_adr[tendon], model.tendon_num[tendon]
    for k in range(start, start + count):
        kind, element = model.wrap_type[k], model.wrap_objid[k]
        if kind == _SITE:
            bodies.append(model.site_bodyid[element])
        elif kind in _GEOMS:
            bodies.append(model.geom_bodyid[element])
    for body in bodies:
        tree = model.body_treeid[body]
        if tree >= 0 and model.tree_sleep_policy[tree] not in _NEVER:
            root = model.name(_OBJ.mjOBJ_BODY, model.body_rootid[body])
            raise InvalidValueError(
                f"{where}: tendon {model.name(_OBJ.mjOBJ_TENDON, tendon)!r} moves body {root!r}, "
                'which may fall asleep while the tendon pulls; give that body sleep="never"'
            )
