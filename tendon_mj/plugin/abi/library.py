"""The running MuJoCo library: its C functions, for Python and for compiled code, and its rules.

`control`, `is_stage` and `warn` repeat or read in compiled code what MuJoCo does.
"""

from __future__ import annotations

import ctypes
from pathlib import Path

import llvmlite.binding as llvm
import mujoco
from numba import types

from tendon_mj.compilation import compiled
from tendon_mj.errors import EngineError
from tendon_mj.plugin.abi.layout import Layout
from tendon_mj.plugin.abi.memory import (
    byte,
    double,
    doubles,
    integer,
    local_doubles,
    pointer,
    set_byte,
)


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
C.mj_deleteData.restype = None
C.mj_deleteData.argtypes = [ctypes.c_void_p]
C.mj_name2id.restype = ctypes.c_int
C.mj_name2id.argtypes = [ctypes.c_void_p, ctypes.c_int, ctypes.c_char_p]
C.strtod.restype = ctypes.c_double
C.strtod.argtypes = [ctypes.c_char_p, ctypes.c_void_p]
C.mjp_registerPlugin.restype = ctypes.c_int


class _PluginHead(ctypes.Structure):
    """The first field of `mjpPlugin`."""

    _fields_ = (("name", ctypes.c_char_p),)


C.mjp_getPluginAtSlot.restype = ctypes.POINTER(_PluginHead)
C.mjp_getPluginAtSlot.argtypes = [ctypes.c_int]

# Compiled code finds its external functions by name: those of MuJoCo and of the C library.
llvm.load_library_permanently(str(PATH))
_char_p = types.intp  # pointers travel as integers
mj_id2name = types.ExternalFunction("mj_id2name", types.intp(types.intp, types.int32, types.int32))
mj_name2id = types.ExternalFunction("mj_name2id", types.int32(types.intp, types.int32, _char_p))
mjp_getPluginAtSlot = types.ExternalFunction("mjp_getPluginAtSlot", types.intp(types.int32))
mj_markStack = types.ExternalFunction("mj_markStack", types.void(types.intp))
mj_freeStack = types.ExternalFunction("mj_freeStack", types.void(types.intp))
mj_stackAllocNum = types.ExternalFunction("mj_stackAllocNum", types.intp(types.intp, types.uintp))
mj_fwdActuation = types.ExternalFunction("mj_fwdActuation", types.void(types.intp, types.intp))
mj_actuatorDamping = types.ExternalFunction(
    "mj_actuatorDamping", types.float64(types.intp, types.int32, types.int32, types.intp)
)
mju_polyForce = types.ExternalFunction(
    "mju_polyForce",
    types.float64(types.float64, types.intp, types.float64, types.int32, types.int32),
)
mju_transformSpatial = types.ExternalFunction(
    "mju_transformSpatial",
    types.void(types.intp, types.intp, types.int32, types.intp, types.intp, types.intp),
)
mjv_initGeom = types.ExternalFunction(
    "mjv_initGeom",
    types.void(types.intp, types.int32, types.intp, types.intp, types.intp, types.intp),
)
mjv_connector = types.ExternalFunction(
    "mjv_connector",
    types.void(types.intp, types.int32, types.float64, types.intp, types.intp),
)
# both take a format and values; a format without a percent sign has no values
mju_warning = types.ExternalFunction("mju_warning", types.void(_char_p))
mju_error = types.ExternalFunction("mju_error", types.void(_char_p))
strtod = types.ExternalFunction("strtod", types.float64(_char_p, types.intp))


@compiled
def control(layout: Layout, m: int, d: int, actuator: int) -> float:
    """Control of an actuator, within its range; 0 where there is no actuator."""
    if actuator < 0:
        return 0.0
    adr = integer(pointer(m + layout.m_actuator_ctrladr), actuator)
    value = double(pointer(d + layout.d_ctrl), adr)
    if byte(pointer(m + layout.m_actuator_ctrllimited), adr):
        limits = doubles(pointer(m + layout.m_actuator_ctrlrange) + 16 * adr, 2)
        value = min(max(value, limits[0]), limits[1])
    return value


RK4 = 1  # mjINT_RK4


@compiled
def is_stage(layout: Layout, m: int, time: float, has_trial: float, trial_time: float) -> bool:
    """Whether this evaluation is an inner stage of Runge-Kutta, which must leave no trace."""
    if integer(m + layout.o_integrator, 0) != RK4 or has_trial == 0.0:
        return False
    h = double(m + layout.o_timestep, 0)
    since = time - trial_time
    return 0.25 * h < since < 1.25 * h


_SIZE = 512  # bytes of a message, with the zero that ends it
_PERCENT = 37
_INNER, _FIRST = 128, 192  # of a letter's bytes in UTF-8, all but the first lie between these
_buffer = local_doubles(_SIZE // 8)


@compiled
def _append(message: int, used: int, text: int, limit: int) -> int:
    """Copy a text, or what fits of it, behind the first ``used`` bytes; return how many there are.

    `mju_warning` takes a format as `printf` does: a percent sign in a name is doubled.
    """
    index = 0
    letter = byte(text, 0)
    while letter != 0 and used < limit - 1:
        set_byte(message + used, letter)
        used += 1
        if letter == _PERCENT:
            set_byte(message + used, letter)
            used += 1
        index += 1
        letter = byte(text, index)
    if _INNER <= letter < _FIRST:  # no letter is cut in two, which no handler in Python survives
        while used > 0 and _INNER <= byte(message, used - 1) < _FIRST:
            used -= 1
        used -= 1
    return used


@compiled
def warn(before: int, name: int, after: int) -> None:
    """Warn by `mju_warning` with a text, a name and a text, at addresses of C strings."""
    message = _buffer()
    used = _append(message, 0, before, _SIZE // 4)
    used = _append(message, used, name, _SIZE // 2)
    used = _append(message, used, after, _SIZE - 1)
    set_byte(message + used, 0)
    mju_warning(message)
