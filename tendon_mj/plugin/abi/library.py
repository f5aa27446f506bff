"""The running MuJoCo library: its C functions, for Python and for compiled code."""

from __future__ import annotations

import ctypes
from pathlib import Path

import llvmlite.binding as llvm
import mujoco
from numba import types

from tendon_mj.errors import EngineError


def _find() -> Path:
    folder = Path(mujoco.__file__).parent
    for pattern in ("libmujoco.so*", "libmujoco*.dylib", "mujoco.dll"):
        for found in sorted(folder.glob(pattern)):
            return found
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


class PluginHead(ctypes.Structure):
    """The first field of `mjpPlugin`, enough to know a plugin by its name."""

    _fields_ = (("name", ctypes.c_char_p),)


C.mjp_getPluginAtSlot.restype = ctypes.POINTER(PluginHead)
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
# both take a format and values; without a percent sign it asks for none
mju_warning = types.ExternalFunction("mju_warning", types.void(_char_p))
mju_error = types.ExternalFunction("mju_error", types.void(_char_p))
strtod = types.ExternalFunction("strtod", types.float64(_char_p, types.intp))
