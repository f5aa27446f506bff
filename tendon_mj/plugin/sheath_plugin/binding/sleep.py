"""Refusal of sheaths on bodies that may fall asleep.

MuJoCo neither computes the path of a tendon whose bodies sleep, nor wakes them for what a plugin
does to them: a sheath would act with the path of the moment when they fell asleep, or not at all.
"""

from __future__ import annotations

import ctypes
from collections.abc import Iterable

import mujoco

from tendon_mj.errors import InvalidValueError
from tendon_mj.plugin.abi.layout import mirror
from tendon_mj.plugin.abi.library import C
from tendon_mj.plugin.abi.model_in_compilation import Draft

_OBJ, _WRAP, _POLICY = mujoco.mjtObj, mujoco.mjtWrap, mujoco.mjtSleepPolicy
_NEVER = (_POLICY.mjSLEEP_NEVER.value, _POLICY.mjSLEEP_AUTO_NEVER.value)
_GEOMS = (_WRAP.mjWRAP_SPHERE.value, _WRAP.mjWRAP_CYLINDER.value)


def sleeps(model: Draft) -> bool:
    """Whether a model lets bodies fall asleep."""
    option = mirror("mjModel").opt.offset + mirror("mjOption").enableflags.offset
    flags = ctypes.c_int.from_address(model.address + option).value
    return bool(flags & mujoco.mjtEnableBit.mjENBL_SLEEP.value)


def check_awake(model: Draft, tendon: int, spools: Iterable[str], where: str) -> None:
    """Refuse a tendon with a body on its path or a joint of a spool that may fall asleep.

    Raises:
        InvalidValueError: names the tendon, the body and the remedy.
    """
    bodies = []
    for name in filter(None, spools):
        joint = C.mj_name2id(model.address, _OBJ.mjOBJ_JOINT.value, name.encode())
        bodies.append(model.ints("jnt_bodyid")[joint])
    start, count = model.ints("tendon_adr")[tendon], model.ints("tendon_num")[tendon]
    for k in range(start, start + count):
        kind, element = model.ints("wrap_type")[k], model.ints("wrap_objid")[k]
        if kind == _WRAP.mjWRAP_SITE.value:
            bodies.append(model.ints("site_bodyid")[element])
        elif kind in _GEOMS:
            bodies.append(model.ints("geom_bodyid")[element])
    for body in bodies:
        tree = model.ints("body_treeid")[body]
        if tree >= 0 and model.ints("tree_sleep_policy")[tree] not in _NEVER:
            root = model.name(_OBJ.mjOBJ_BODY, model.ints("body_rootid")[body])
            raise InvalidValueError(
                f"{where}: tendon {model.name(_OBJ.mjOBJ_TENDON, tendon)!r} moves body {root!r}, "
                'which may fall asleep while the tendon pulls; give that body sleep="never"'
            )
