"""What Python adds to the checks of compiled code: names that may be meant, and a few checks.

MuJoCo neither computes the path of a tendon whose bodies sleep, nor wakes them for a plugin's
forces: a sheath would act with the path of the moment when they fell asleep, or not at all. Sheaths
on bodies that may fall asleep are refused.

MuJoCo leaves a refusal by a long jump, which must not cross a Python frame: Python writes a text
into the message of a compiled check, which raises it after Python has returned.
"""

from __future__ import annotations

import ctypes
from collections.abc import Iterable
from typing import Any

import mujoco
import numpy as np

from tendon_mj.errors import InvalidValueError, TendonError, suggestion
from tendon_mj.plugin.abi import Draft, attribute_of, plugin_at
from tendon_mj.plugin.compiled_checks import LISTS, MORE
from tendon_mj.plugin.force_servo_plugin import FEEDBACKS, SWITCH
from tendon_mj.plugin.sheath_plugin import (
    INPUT_ENDS,
    KINDS,
    NAME,
    SPRINGS,
    attachment,
    check_tension_scale,
)

_OBJ, _WRAP, _POLICY = mujoco.mjtObj, mujoco.mjtWrap, mujoco.mjtSleepPolicy
_GEOMS = (_WRAP.mjWRAP_SPHERE.value, _WRAP.mjWRAP_CYLINDER.value)
_NEVER = (_POLICY.mjSLEEP_NEVER.value, _POLICY.mjSLEEP_AUTO_NEVER.value)
_SLEEPS = mujoco.mjtEnableBit.mjENBL_SLEEP.value
_WORDS = {
    "sensor": KINDS,
    "input_end": INPUT_ENDS,
    "spring": SPRINGS,
    "feedback": FEEDBACKS,
    "backdrive": SWITCH,
}
_LENGTH = 1023  # bytes of a text


def _names(model: Draft, kind: str) -> Iterable[str]:
    """Names of the kind that a model has, or words that an attribute may have."""
    if kind == "tendon":
        tendons = (model.name(_OBJ.mjOBJ_TENDON, k) for k in range(model.ntendon))
        return filter(None, tendons)
    if kind == "joint":
        return [model.name(_OBJ.mjOBJ_JOINT, k) for k in range(model.njnt)]
    if kind in _WORDS:
        return _WORDS[kind]
    sheaths = [k for k in range(model.nplugin) if _is_sheath(model, k)]
    on = (int(attachment(model.address, k).tendon) for k in sheaths)
    return [model.name(_OBJ.mjOBJ_TENDON, tendon) for tendon in on if tendon >= 0]


def _is_sheath(model: Draft, instance: int) -> bool:
    is_ours = plugin_at(model.plugin[instance]) == NAME
    return is_ours and not attribute_of(model.address, instance, "sensor")


def _said(address: int, which: int, argument: int) -> str:
    """Text about a name at an address; empty for checks that pass, whose argument is an instance.

    Raises:
        InvalidValueError, UnknownNameError: a check fails.
    """
    model = Draft(address)
    if which != MORE:
        name = ctypes.string_at(argument).decode(errors="replace")
        return suggestion(LISTS[which], name, _names(model, LISTS[which]))
    instances = np.flatnonzero(model.plugin == model.plugin[argument]).tolist()
    if instances[0] == argument and plugin_at(model.plugin[argument]) == NAME:
        check_tension_scale(model)
        for instance in instances:
            if _is_sheath(model, instance):
                _check_sheath(model, instance)
    return ""


def _write(reply: int, address: int, which: int, argument: int) -> None:
    """Write a text at an address."""
    try:
        text = _said(address, which, argument)
    except KeyboardInterrupt:
        return  # ctypes would print it; the text that is there says so
    except TendonError as error:
        text = str(error)
    except Exception as error:
        text = f"tendon_mj: {error!r}"
    written = text.encode()[: _LENGTH // 2].decode(errors="ignore").replace("%", "%%").encode()
    ctypes.memmove(reply, written + b"\0", len(written) + 1)  # mju_error takes a format


# which compiled code calls
write_advice: Any = ctypes.CFUNCTYPE(
    None, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_int, ctypes.c_size_t
)(_write)


def _check_sheath(model: Draft, instance: int) -> None:
    """Refuse a spring that yields, and bodies that may fall asleep."""
    bound = attachment(model.address, instance)
    tendon = int(bound.tendon)
    if tendon < 0:
        return
    name = model.name(_OBJ.mjOBJ_PLUGIN, instance)
    where = f"plugin {NAME} instance {name!r}" if name else f"plugin {NAME}"
    where += f": tendon {model.name(_OBJ.mjOBJ_TENDON, tendon)!r}"
    limit = model.tendon_springyield[tendon] if hasattr(model, "tendon_springyield") else 0.0
    if limit > 0.0:  # as it may from MuJoCo 4 on
        raise InvalidValueError(
            f"{where} has springyield = {limit:g} N, and a sheath does not follow a spring that"
            " stays deformed; set it to 0"
        )
    if model.opt.enableflags & _SLEEPS:
        _check_awake(model, tendon, (bound.reel_joint, bound.output_joint), where)


def _check_awake(model: Draft, tendon: int, joints: Iterable[float], where: str) -> None:
    """Refuse a tendon that moves a body which may fall asleep, by itself or by a spool.

    Raises:
        InvalidValueError: names the tendon, the body and the remedy.
    """
    bodies = [model.jnt_bodyid[int(joint)] for joint in joints if joint >= 0.0]
    start, count = model.tendon_adr[tendon], model.tendon_num[tendon]
    for k in range(start, start + count):
        kind, element = model.wrap_type[k], model.wrap_objid[k]
        if kind == _WRAP.mjWRAP_SITE.value:
            bodies.append(model.site_bodyid[element])
        elif kind in _GEOMS:
            bodies.append(model.geom_bodyid[element])
        elif kind == _WRAP.mjWRAP_JOINT.value:
            bodies.append(model.jnt_bodyid[element])
    for body in bodies:
        tree = model.body_treeid[body]
        if tree >= 0 and model.tree_sleep_policy[tree] not in _NEVER:
            root = model.name(_OBJ.mjOBJ_BODY, model.body_rootid[body])
            raise InvalidValueError(
                f"{where} moves body {root!r}, which may fall asleep while the tendon pulls; "
                'give that body sleep="never"'
            )
