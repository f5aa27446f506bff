"""Checks of a tendon's path, once, while MuJoCo compiles the model."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import mujoco

from tendon_mj.errors import InvalidValueError
from tendon_mj.plugin.abi.model_in_compilation import Draft

UNDRAWN = ("extra_bend", "constant_friction")  # friction that is not where the path bends
_OBJ, _WRAP = mujoco.mjtObj, mujoco.mjtWrap
_PULLEY = _WRAP.mjWRAP_PULLEY.value


def kinds_on(model: Draft, tendon: int) -> list[int]:
    """Kinds of the elements on a tendon's path, as `mjtWrap` has them."""
    start, count = model.ints("tendon_adr")[tendon], model.ints("tendon_num")[tendon]
    return list(model.ints("wrap_type")[start : start + count])


def unsuited(kinds: Sequence[int], driven: bool) -> str:
    """Why a tendon with such elements on its path cannot run in a sheath; empty if it can."""
    if _WRAP.mjWRAP_JOINT.value in kinds:
        return "is a fixed tendon; only a spatial one runs in a sheath"
    if _PULLEY in kinds and not driven:
        return (
            "branches at a pulley, which only a tendon that an actuator pulls on may; give each "
            "branch a tendon of its own"
        )
    if _PULLEY in (kinds[0], kinds[-1]) or any(
        one == other == _PULLEY for one, other in itertools.pairwise(kinds)
    ):
        return "has a pulley without a branch before and behind it"
    return ""


def misplaced_input(model: Draft, tendon: int, input_end: str) -> str:
    """Why a tendon cannot have its input at this end; empty if it can."""
    kinds = kinds_on(model, tendon)
    if input_end != "last" or _PULLEY not in kinds:
        return ""
    element = model.ints("tendon_adr")[tendon] + kinds.index(_PULLEY) - 1
    site = model.name(_OBJ.mjOBJ_SITE, model.ints("wrap_objid")[element])
    return (
        f"branches at a pulley, behind its site {site!r}, and every branch has its input where it "
        "begins: leave out input_end = last and draw each branch from its input on, or give each "
        "a tendon of its own"
    )


def check_counts(config: dict[str, str], kinds: Sequence[int], where: str, tendon: str) -> None:
    """Check that the counts, where they are given, are those of the path."""
    arcs = sum(k in (_WRAP.mjWRAP_SPHERE.value, _WRAP.mjWRAP_CYLINDER.value) for k in kinds)
    pulleys = sum(k == _PULLEY for k in kinds)
    each = int(config["arc_guides"] or 1)
    sites = len(kinds) - arcs - pulleys - 2 * (1 + pulleys)
    guides = sites + arcs * each + pulleys + int(config["inner_guides"] or 0)
    if config["guides"] and int(config["guides"]) != guides:
        raise InvalidValueError(
            f"{where}: guides = {config['guides']}, but tendon {tendon!r} runs over {guides} "
            "between its ends; remove the attribute or correct it"
        )
    undrawn = [k for k in UNDRAWN if config[k] and float(config[k]) != 0.0]
    if undrawn and arcs and guides == arcs * each + pulleys:
        raise InvalidValueError(
            f"{where}: {undrawn[0]} = {config[undrawn[0]]} is shared by guides at sites, as the "
            f"tendon may leave a geom, and tendon {tendon!r} has none: give inner_guides"
        )
    if arcs and config["guides"] and not config["arc_guides"]:
        raise InvalidValueError(
            f"{where}: tendon {tendon!r} wraps around geoms: beside guides, arc_guides has to be "
            "given too, the number of guides on each of them"
        )
