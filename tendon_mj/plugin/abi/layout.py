"""Byte offsets of the fields that the plugins use inside MuJoCo's structs.

The offsets come from `mujoco.introspect`, MuJoCo's own description of its headers, through ctypes,
which knows the C rules of alignment. Before they are used, `verify` compares each array that they
point to with the one that the Python bindings show, and `verify_scene` those of a scene.
"""

from __future__ import annotations

import ctypes
import functools
import math
from collections.abc import Mapping
from pathlib import Path
from types import SimpleNamespace
from typing import Any, Final, TypeAlias

import mujoco
import numpy as np
from mujoco.introspect import ast_nodes, structs

from tendon_mj.errors import EngineError
from tendon_mj.native import Constants, Field, Struct

_SCALARS: dict[str, Any] = {
    "char": ctypes.c_char,
    "int": ctypes.c_int,
    "float": ctypes.c_float,
    "mjtNum": ctypes.c_double,
    "mjtSize": ctypes.c_int64,
    "size_t": ctypes.c_size_t,
    "uintptr_t": ctypes.c_size_t,
    "uint64_t": ctypes.c_uint64,
    "mjtBool": ctypes.c_bool,
    "mjtByte": ctypes.c_ubyte,
}


TABLE: Final = Path(__file__).with_name("offsets.csv")  # its rows are the fields that are used


def _listed(*owners: str) -> list[str]:
    """Entries of these owners in the table."""
    lines = TABLE.read_text(encoding="utf-8").splitlines()
    return [line.partition(",")[0] for line in lines if line.startswith(owners)]


# Byte offsets in `mjModel` (m_), its `opt` (o_) and `mjData` (d_); `equality_bytes` of `eq_data`
# that each equality has, which are more from MuJoCo 3.17 on.
LAYOUT: Final = Constants("tendon_mj_layout", _listed("m_", "o_", "d_", "equality_"))
# Byte offsets in `mjvScene` (s_), `mjvGeom` (g_) and `mjvOption` (v_); `geom_bytes` of each geom.
SCENE: Final = Constants("tendon_mj_scene_layout", _listed("s_", "g_", "v_", "geom_"))


_OWNER = {
    "m": "mjModel",
    "o": "mjOption",
    "d": "mjData",
    "s": "mjvScene",
    "g": "mjvGeom",
    "v": "mjvOption",
}


# What compiled functions take; in Python, a `mujoco.MjModel` and so on.
Model: TypeAlias = Any
Data: TypeAlias = Any
Option: TypeAlias = Any  # `mujoco.MjvOption`
Scene: TypeAlias = Any


def _ctype(declared: Any) -> Any:
    """The ctypes type that has the size and alignment of a declared C type."""
    if isinstance(declared, ast_nodes.PointerType):
        return ctypes.c_void_p
    if isinstance(declared, ast_nodes.ArrayType):
        inner = _ctype(declared.inner_type)
        for extent in reversed(declared.extents):
            inner = inner * extent
        return inner
    if isinstance(declared, ast_nodes.AnonymousStructDecl):
        return _structure(declared.fields)
    if isinstance(declared, ast_nodes.ValueType):
        if declared.name in _SCALARS:
            return _SCALARS[declared.name]
        if declared.name in structs.STRUCTS:
            return _structure(structs.STRUCTS[declared.name].fields)
    raise EngineError(
        f"mujoco {mujoco.__version__} declares a field of type {declared}, whose size this version "
        "of tendon-mj does not know"
    )


def _structure(fields: Any) -> Any:
    members = [(f.name, _ctype(f.type)) for f in fields]
    return type("Structure", (ctypes.Structure,), {"_fields_": members})


@functools.cache
def mirror(struct: str) -> Any:
    """A ctypes structure with the fields of one of MuJoCo's structs."""
    return _structure(structs.STRUCTS[struct].fields)


@functools.cache
def _declarations(struct: str) -> dict[str, Any]:
    return {declared.name: declared for declared in structs.STRUCTS[struct].fields}


@functools.cache
def field(struct: str, name: str) -> Field | None:
    """Description of a field of one of MuJoCo's structs, None if it has no such field."""
    declared = _declarations(struct).get(name)
    if declared is None:
        return None
    if isinstance(declared.type, ast_nodes.ValueType):
        return Field(_kind(declared.type))
    kind = _kind(declared.type.inner_type)
    if kind in structs.STRUCTS:
        return Field(kind, 1, "geom_bytes")
    row: int | str = np.dtype(kind).itemsize
    if isinstance(declared.type, ast_nodes.ArrayType):
        return Field(kind, 1, row, is_inline=True)
    columns = _columns(declared)
    row = "equality_bytes" if name == "eq_data" else row * math.prod(columns)
    return Field(kind, 1 + len(columns), row)


def field_at(struct: str, address: int, name: str) -> Any:
    """A field of the struct at an address, as the Python bindings have it.

    Raises:
        AttributeError: there is no such field.
    """
    held = mirror(struct).from_address(address)
    value, described = getattr(held, name), field(struct, name)
    if described is None or described.dimensions == 0:
        return value
    declared = _declarations(struct)[name]
    shape = (getattr(held, declared.array_extent[0]), *_columns(declared))
    dtype = np.dtype(_ctype(declared.type.inner_type))
    if not value or 0 in shape:
        return np.empty(shape, dtype)
    # an array type of ctypes, one for each length, would leave some memory behind
    shown = {"data": (value, False), "shape": shape, "typestr": dtype.str, "version": 3}
    return np.asarray(SimpleNamespace(__array_interface__=shown))


def _columns(declared: Any) -> list[int]:
    """Extents of an array behind the first."""
    extents = declared.array_extent[1:]
    return [extent if isinstance(extent, int) else getattr(mujoco, extent) for extent in extents]


def _kind(declared: Any) -> str:
    """Kind of a number as NumPy has it, bytes for flags and letters; or symbol of a struct."""
    if declared.name in structs.STRUCTS:
        return str(declared.name)
    dtype = np.dtype(_ctype(declared))
    return "uint8" if dtype.itemsize == 1 else dtype.name


for _prefix, _symbol in _OWNER.items():
    Struct(_symbol, _prefix, functools.partial(field, _symbol))


def offset(entry: str) -> int:
    """Offset of a field, which is named ``owner_field``."""
    if entry == "geom_bytes":
        return ctypes.sizeof(mirror("mjvGeom"))
    if entry == "equality_bytes":
        return ctypes.sizeof(ctypes.c_double) * mujoco.mjNEQDATA
    owner, name = entry.split("_", 1)
    member = getattr(mirror(_OWNER[owner]), name, None)
    if member is None:
        raise EngineError(
            f"mujoco {mujoco.__version__} has no {_OWNER[owner]}.{name}, which tendon-mj uses; "
            "install a version that its pyproject.toml names"
        )
    own: int = member.offset
    return own + (mirror("mjModel").opt.offset if owner == "o" else 0)


def read(layout: Constants) -> dict[str, int]:
    """Offsets of `LAYOUT` or `SCENE` for the MuJoCo that is running.

    Raises:
        EngineError: a field is gone or has an unknown type.
    """
    return {entry: offset(entry) for entry in layout.names}


_SCENE = "<mujoco><worldbody><geom size='.1'/><geom size='.1'/></worldbody></mujoco>"
_CANARY = """
<mujoco>
  <option timestep="0.0123" integrator="RK4"/>
  <custom><numeric name="n" data="1 2"/></custom>
  <extension>
    <plugin plugin="mujoco.pid">
      <instance name="p"><config key="kp" value="1"/></instance>
    </plugin>
  </extension>
  <worldbody>
    <site name="a"/>
    <body pos="1 0 0"><joint name="j"/><geom size=".1"/><site name="b"/></body>
  </worldbody>
  <tendon><spatial name="t"><site site="a"/><site site="b"/></spatial></tendon>
  <actuator>
    <plugin name="p" plugin="mujoco.pid" instance="p" joint="j" ctrlrange="-1 2"/>
  </actuator>
  <sensor><clock/><jointpos joint="j"/></sensor>
</mujoco>
"""


def verify(layout: Mapping[str, int]) -> None:
    """Compare the offsets with the bindings, on a model made for this.

    Raises:
        EngineError: names the first field that does not agree.
    """
    model = mujoco.MjModel.from_xml_string(_CANARY)
    data = mujoco.MjData(model)
    data.time = 0.625
    owners = {"m": (model, model), "o": (model, model.opt), "d": (data, data)}
    for entry, offset in layout.items():
        owner, name = entry.split("_", 1)
        if entry == "equality_bytes":
            _require(model.eq_data.itemsize * model.eq_data.shape[1] == offset, "mjModel.eq_data")
            continue
        holder, shower = owners[owner]
        _compare(holder._address + offset, getattr(shower, name, None), f"{_OWNER[owner]}.{name}")


def verify_state(layout: Mapping[str, int], data: mujoco.MjData) -> None:
    """Compare the offset of the one array that only a model with the plugin fills.

    Raises:
        EngineError: it is not where the offsets say.
    """
    _compare(data._address + layout["d_plugin_state"], data.plugin_state, "mjData.plugin_state")


def verify_scene(layout: Mapping[str, int]) -> None:
    """Compare the offsets of a scene with the bindings.

    Raises:
        EngineError: names the first field that does not agree.
    """
    model = mujoco.MjModel.from_xml_string(_SCENE)
    data, option, scene = mujoco.MjData(model), mujoco.MjvOption(), mujoco.MjvScene(model, 5)
    mujoco.mj_kinematics(model, data)
    camera, kinds = mujoco.MjvCamera(), mujoco.mjtCatBit.mjCAT_ALL.value
    mujoco.mjv_updateScene(model, data, option, None, camera, kinds, scene)
    first, second = scene.geoms[:2]
    first.objtype, first.objid, first.segid = 11, 12, 13
    first.emission, first.specular = 0.375, 0.625
    scene.status = 14
    # each begins where an array that the bindings show lies, less its offset
    start = {
        "s": scene.flags.ctypes.data - mirror("mjvScene").flags.offset,
        "g": first.pos.ctypes.data - layout["g_pos"],
        "v": option.flags.ctypes.data - layout["v_flags"],
    }
    shown = {"s": scene, "g": first, "v": option}
    for entry, offset in layout.items():
        owner, _, name = entry.partition("_")
        if entry == "geom_bytes":
            _require(second.pos.ctypes.data - first.pos.ctypes.data == offset, "mjvGeom")
        elif entry == "s_geoms":
            held = ctypes.c_size_t.from_address(start["s"] + offset).value
            _require(held == start["g"], "mjvScene.geoms")
        else:
            field = getattr(shown[owner], name)
            _compare(start[owner] + offset, field, f"{_OWNER[owner]}.{name}", ctypes.c_float)
            if isinstance(field, np.ndarray):  # which the struct holds itself
                _require(field.ctypes.data == start[owner] + offset, f"{_OWNER[owner]}.{name}")


def _compare(address: int, shown: object, name: str, real: Any = ctypes.c_double) -> None:
    if isinstance(shown, np.ndarray) and shown.size:
        held = ctypes.c_size_t.from_address(address).value
        # arrays that a struct holds itself, not by pointer, start at the address
        _require(shown.ctypes.data in (held, address), name)
    elif isinstance(shown, bool | int | float):
        kind = {bool: ctypes.c_bool, int: ctypes.c_int}.get(type(shown), real)
        _require(kind.from_address(address).value == shown, name)


def _require(agrees: bool, name: str) -> None:
    if not agrees:
        raise EngineError(
            f"mujoco {mujoco.__version__}: {name} is not where its description says; tendon-mj "
            "will not use memory that it may misread"
        )
