"""The running MuJoCo library: its C functions, for Python and for compiled code, and its rules.

`control`, `geared_control`, `is_stage` and `warn` repeat or read in compiled code what MuJoCo does.
"""

from __future__ import annotations

import ctypes
from pathlib import Path
from typing import SupportsInt

import mujoco

from tendon_mj.errors import EngineError
from tendon_mj.native import EngineFunction, External, LocalDoubles, apart, compiled
from tendon_mj.plugin.abi.layout import Data, Model
from tendon_mj.plugin.abi.memory import letters, word, words


def _find() -> Path:
    folder = Path(mujoco.__file__).parent
    for pattern in ("libmujoco.so*", "libmujoco*.dylib", "mujoco.dll"):
        for library in sorted(folder.glob(pattern)):
            return library
    raise EngineError(f"no MuJoCo library in {folder}: is the mujoco package complete?")


PATH = _find()
C = ctypes.CDLL(str(PATH))
C.mj_getPluginConfig.restype = ctypes.c_char_p
C.mj_getPluginConfig.argtypes = [ctypes.c_void_p, ctypes.c_int, ctypes.c_char_p]
C.mj_id2name.restype = ctypes.c_char_p
C.mj_id2name.argtypes = [ctypes.c_void_p, ctypes.c_int, ctypes.c_int]
C.mj_actuatorDisabled.argtypes = [ctypes.c_void_p, ctypes.c_int]
C.mj_deleteData.restype = None
C.mj_deleteData.argtypes = [ctypes.c_void_p]
C.mj_name2id.restype = ctypes.c_int
C.mj_name2id.argtypes = [ctypes.c_void_p, ctypes.c_int, ctypes.c_char_p]
C.mjp_getPlugin.restype = ctypes.c_void_p
C.mjp_getPlugin.argtypes = [ctypes.c_char_p, ctypes.c_void_p]


class _PluginHead(ctypes.Structure):
    """The first field of `mjpPlugin`."""

    _fields_ = (("name", ctypes.c_char_p),)


C.mjp_getPluginAtSlot.restype = ctypes.POINTER(_PluginHead)
C.mjp_getPluginAtSlot.argtypes = [ctypes.c_int]


def plugin_at(slot: SupportsInt) -> str:
    """Name of the plugin in a slot, empty if there is none."""
    plugin = C.mjp_getPluginAtSlot(int(slot))
    return bytes(plugin.contents.name).decode() if plugin else ""


def attribute_of(model: int, instance: int, attribute: str) -> str:
    """Attribute of a plugin instance of the model at an address, empty if it is not given."""
    return (C.mj_getPluginConfig(model, instance, attribute.encode()) or b"").decode()


# for compiled code
mj_id2name = EngineFunction("mj_id2name", "ptr(ptr, i32, i32)")
mj_name2id = EngineFunction("mj_name2id", "i32(ptr, i32, ptr)")
mjp_getPluginAtSlot = EngineFunction("mjp_getPluginAtSlot", "ptr(i32)")
mj_fwdActuation = EngineFunction("mj_fwdActuation", "void(ptr, ptr)")
mj_rne = EngineFunction("mj_rne", "void(ptr, ptr, i32, ptr)")
mj_referenceConstraint = EngineFunction("mj_referenceConstraint", "void(ptr, ptr)")
mj_isSparse = EngineFunction("mj_isSparse", "i32(ptr)")
mj_applyFT = EngineFunction("mj_applyFT", "void(ptr, ptr, ptr, ptr, ptr, i32, ptr)")
mj_passive = EngineFunction("mj_passive", "void(ptr, ptr)")
mj_actuatorDamping = EngineFunction("mj_actuatorDamping", "f64(ptr, i32, i32, ptr)")
mj_actuatorDisabled = EngineFunction("mj_actuatorDisabled", "i32(ptr, i32)")
mju_polyForce = EngineFunction("mju_polyForce", "f64(f64, ptr, f64, i32, i32)")
mju_transformSpatial = EngineFunction("mju_transformSpatial", "void(ptr, ptr, i32, ptr, ptr, ptr)")
mjv_initGeom = EngineFunction("mjv_initGeom", "void(ptr, i32, ptr, ptr, ptr, ptr)")
mjv_connector = EngineFunction("mjv_connector", "void(ptr, i32, f64, ptr, ptr)")
# both take a format and values; a format without a percent sign has no values
mju_warning = EngineFunction("mju_warning", "void(ptr)")
mju_error = EngineFunction("mju_error", "void(ptr)")
malloc = External("malloc", "ptr(i64)")
free = External("free", "void(ptr)")
mj_version = EngineFunction("mj_version", "i32()")
mjp_getPlugin = EngineFunction("mjp_getPlugin", "ptr(ptr, ptr)")
mjp_pluginCount = EngineFunction("mjp_pluginCount", "i32()")
mjp_registerPlugin = EngineFunction("mjp_registerPlugin", "i32(ptr)")
mj_deleteData = EngineFunction("mj_deleteData", "void(ptr)")
_strtod = External("strtod", "f64(ptr, ptr)")
_localeconv = External("localeconv", "ptr()")
_POINT = 46  # "."
_LONGEST = 120  # bytes of a number, where its decimal point has to be replaced
_copy = LocalDoubles(_LONGEST // 8 + 1)


@apart
def read_number(text: int, end: int) -> float:
    """Number at the beginning of a text, whatever the locale; ``end`` receives where it ends."""
    point = letters(word(_localeconv()))[0]
    if point == _POINT:
        return _strtod(text, end)
    copy, count = _copy(), 0
    letter = letters(text)[0]
    while letter != 0 and letter != point and count < _LONGEST:
        letters(copy)[count] = point if letter == _POINT else letter
        count += 1
        letter = letters(text)[count]
    letters(copy)[count] = 0
    value = _strtod(copy, end)
    words(end)[0] = text + word(end) - copy
    return value


_CLAMPCTRL_OFF = mujoco.mjtDisableBit.mjDSBL_CLAMPCTRL.value
_ACTUATION_OFF = mujoco.mjtDisableBit.mjDSBL_ACTUATION.value


@compiled
def control(m: Model, d: Data, actuator: int) -> float:
    """Control of an actuator, within its range unless the flag `clampctrl` is off."""
    adr = m.actuator_ctrladr[actuator]
    value = d.ctrl[adr]
    clamps = m.opt.disableflags & _CLAMPCTRL_OFF == 0
    if clamps and m.actuator_ctrllimited[adr]:
        limits = m.actuator_ctrlrange[adr]
        value = min(max(value, limits[0]), limits[1])
    return value


@compiled
def geared_control(m: Model, d: Data, actuator: int) -> float:
    """Control of an actuator times its gear; 0 if there is none, or it is disabled."""
    if actuator < 0 or m.opt.disableflags & _ACTUATION_OFF:
        return 0.0
    if mj_actuatorDisabled(m, actuator) != 0:
        return 0.0
    adr = m.actuator_outadr[actuator]
    return m.actuator_gear[adr, 0] * control(m, d, actuator)


@compiled
def plugin_name(m: Model, instance: int) -> int:
    """Address of the name of an instance's plugin."""
    return word(mjp_getPluginAtSlot(m.plugin[instance]))


RK4 = 1  # mjINT_RK4


@compiled
def is_stage(m: Model, time: float, has_trial: float, trial_time: float) -> bool:
    """Return whether this is an inner stage of Runge-Kutta, which must leave no trace."""
    if m.opt.integrator != RK4 or has_trial == 0.0:
        return False
    h = m.opt.timestep
    since = time - trial_time
    return 0.25 * h < since < 1.25 * h


_SIZE = 512  # bytes of a message, with the zero that ends it
_PERCENT = 37
_INNER, _FIRST = 128, 192  # of a letter's bytes in UTF-8, all but the first lie between these
_buffer = LocalDoubles(_SIZE // 8)


@apart
def append(message: int, used: int, text: int, limit: int) -> int:
    """Copy a text, or what fits of it, behind the first ``used`` bytes; return how many there are.

    `mju_warning` takes a format as `printf` does: a percent sign in a name is doubled.
    """
    index = 0
    letter = letters(text)[0]
    while letter != 0 and used < limit - 1:
        letters(message)[used] = letter
        used += 1
        if letter == _PERCENT:
            letters(message)[used] = letter
            used += 1
        index += 1
        letter = letters(text)[index]
    if _INNER <= letter < _FIRST:  # no letter is cut in two, which no handler in Python survives
        while used > 0 and _INNER <= letters(message)[used - 1] < _FIRST:
            used -= 1
        used -= 1
    return used


@compiled
def warn(before: int, name: int, after: int) -> None:
    """Warn by `mju_warning` with a text, a name and a text, at addresses of C strings."""
    message = _buffer()
    used = append(message, 0, before, _SIZE // 4)
    used = append(message, used, name, _SIZE // 2)
    used = append(message, used, after, _SIZE - 1)
    letters(message)[used] = 0
    mju_warning(message)
