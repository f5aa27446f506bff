"""Registers the plugin `tendon_mj.sheath` with the running MuJoCo."""

from __future__ import annotations

import ctypes
import re
from collections.abc import Callable
from pathlib import Path

import llvmlite.binding as llvm
import mujoco
from numba import cfunc, types

from tendon_mj.engine.attributes import ATTRIBUTES
from tendon_mj.engine.callbacks import Callbacks, make_callbacks
from tendon_mj.engine.layout import read_layout, verify, verify_state
from tendon_mj.engine.library import PATH, C, mju_error
from tendon_mj.engine.validate import NAME, check_tendon, sensor_size, state_size
from tendon_mj.errors import EngineError, TendonError

_CAPABILITIES = 1 | 2 | 4  # actuator, sensor, passive: mjtPluginCapabilityBit


class _Plugin(ctypes.Structure):
    """`mjpPlugin` of mjplugin.h."""

    _fields_ = (
        ("name", ctypes.c_char_p),
        ("nattribute", ctypes.c_int),
        ("attributes", ctypes.POINTER(ctypes.c_char_p)),
        ("capabilityflags", ctypes.c_int),
        ("needstage", ctypes.c_int),
        ("nstate", ctypes.c_void_p),
        ("nsensordata", ctypes.c_void_p),
        ("init", ctypes.c_void_p),
        ("destroy", ctypes.c_void_p),
        ("copy", ctypes.c_void_p),
        ("reset", ctypes.c_void_p),
        ("compute", ctypes.c_void_p),
        ("advance", ctypes.c_void_p),
        ("visualize", ctypes.c_void_p),
        ("actuator_act_dot", ctypes.c_void_p),
        ("sdf_distance", ctypes.c_void_p),
        ("sdf_gradient", ctypes.c_void_p),
        ("sdf_staticdistance", ctypes.c_void_p),
        ("sdf_attribute", ctypes.c_void_p),
        ("sdf_aabb", ctypes.c_void_p),
    )


def _verify_struct() -> None:
    """Hold our `mjpPlugin` against the header that MuJoCo ships.

    Raises:
        EngineError: the fields or their order differ.
    """
    header = Path(mujoco.__file__).parent / "include" / "mujoco" / "mjplugin.h"
    if not header.exists():
        raise EngineError(f"{header} is missing, so the plugin's structure cannot be checked")
    body = re.search(r"typedef struct mjpPlugin_ \{(.*?)\} mjpPlugin;", header.read_text(), re.S)
    code = re.sub(r"//[^\n]*", "", body.group(1)) if body else ""
    declared = [
        re.sub(r"\(\*(\w+)\)\(.*", r"\1", part.strip(), flags=re.S).split()[-1].strip("*")
        for part in code.split(";")
        if part.strip()
    ]
    ours = [name for name, _ in _Plugin._fields_]
    if declared != ours:
        raise EngineError(
            f"mujoco {mujoco.__version__} declares mjpPlugin as {declared}, not as {ours}"
        )


_MESSAGE = ctypes.create_string_buffer(2048)


def _guarded(function: Callable[..., int]) -> Callable[..., int]:
    """Turn an exception into −1 and a message, for the C side to raise after Python has left."""

    def call(*arguments: int) -> int:
        try:
            return function(*arguments)
        except Exception as error:
            said = str(error) if isinstance(error, TendonError) else f"{NAME}: {error!r}"
            text = said.replace("%", "%%").encode()
            _MESSAGE.value = text[: len(_MESSAGE) - 1]
            return -1

    return call


_py_state_size = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_void_p, ctypes.c_int)(_guarded(state_size))
_py_sensor_size = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_void_p, ctypes.c_int, ctypes.c_int)(
    _guarded(sensor_size)
)
_py_check = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_void_p, ctypes.c_int)(_guarded(check_tendon))
_i32, _ptr = types.int32, types.intp
for _name, _address in {
    "tendon_mj_state_size": ctypes.cast(_py_state_size, ctypes.c_void_p).value,
    "tendon_mj_sensor_size": ctypes.cast(_py_sensor_size, ctypes.c_void_p).value,
    "tendon_mj_check": ctypes.cast(_py_check, ctypes.c_void_p).value,
    "tendon_mj_message": ctypes.addressof(_MESSAGE),
}.items():
    llvm.add_symbol(_name, _address)
_ask_state_size = types.ExternalFunction("tendon_mj_state_size", _i32(_ptr, _i32))
_ask_sensor_size = types.ExternalFunction("tendon_mj_sensor_size", _i32(_ptr, _i32, _i32))
_check = types.ExternalFunction("tendon_mj_check", _i32(_ptr, _i32))

# Made, not stepped: MuJoCo hands the plugin its state directly then, and no offset is trusted yet.
_SMALLEST = f"""
<mujoco>
  <extension>
    <plugin plugin="{NAME}">
      <instance name="sheath">
        <config key="tendon" value="t"/>
        <config key="friction" value="0"/>
        <config key="axial_stiffness" value="1"/>
      </instance>
    </plugin>
  </extension>
  <worldbody><site name="a"/><site name="b" pos="1 0 0"/></worldbody>
  <tendon><spatial name="t"><site site="a"/><site site="b"/></spatial></tendon>
</mujoco>
"""

_registered: list[object] = []  # what C holds pointers to must outlive it


def _make_checks() -> tuple[object, object, object]:
    message = ctypes.addressof(_MESSAGE)

    @cfunc(_i32(_ptr, _i32))
    def nstate(m: int, instance: int) -> int:
        count = _ask_state_size(m, instance)
        if count < 0:
            mju_error(message)
        return count

    @cfunc(_i32(_ptr, _i32, _i32))
    def nsensordata(m: int, instance: int, sensor: int) -> int:
        count = _ask_sensor_size(m, instance, sensor)
        if count < 0:
            mju_error(message)
        return count

    @cfunc(_i32(_ptr, _ptr, _i32))
    def init(m: int, d: int, instance: int) -> int:
        if _check(m, instance) < 0:
            mju_error(message)
        return 0

    return nstate, nsensordata, init


def register() -> Callbacks:
    """Make `tendon_mj.sheath` known to MuJoCo; a second call does nothing more.

    Raises:
        EngineError: the running MuJoCo does not have the layout that the plugin would read.
    """
    if _registered:
        return _registered[0]  # type: ignore[return-value]
    _verify_struct()
    layout = read_layout()
    verify(layout)
    callbacks = make_callbacks(layout)
    nstate, nsensordata, init = _make_checks()
    names = (ctypes.c_char_p * len(ATTRIBUTES))(*(a.encode() for a in ATTRIBUTES))
    plugin = _Plugin(
        name=NAME.encode(),
        nattribute=len(ATTRIBUTES),
        attributes=names,
        capabilityflags=_CAPABILITIES,
        needstage=mujoco.mjtStage.mjSTAGE_VEL.value,
        nstate=nstate.address,  # type: ignore[attr-defined]
        nsensordata=nsensordata.address,  # type: ignore[attr-defined]
        init=init.address,  # type: ignore[attr-defined]
        reset=callbacks.reset.address,
        compute=callbacks.compute.address,
        advance=callbacks.advance.address,
    )
    _registered.extend([callbacks, nstate, nsensordata, init, names, plugin])
    if C.mjp_registerPlugin(ctypes.byref(plugin)) < 0:
        raise EngineError(f"{PATH.name} refused the plugin {NAME}")
    verify_state(layout, mujoco.MjData(mujoco.MjModel.from_xml_string(_SMALLEST)))
    return callbacks
