"""Where the fields that we read lie inside `mjModel` and `mjData`.

The offsets come from `mujoco.introspect`, MuJoCo's own description of its headers, through ctypes,
which knows the C rules of alignment. Before anything trusts them, `verify` compares each array that
they point to with the one that the Python bindings show.
"""

from __future__ import annotations

import ctypes
import functools
from typing import Any, Final, NamedTuple

import mujoco
import numpy as np
from mujoco.introspect import ast_nodes, structs

from tendon_mj.errors import EngineError

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


class Layout(NamedTuple):
    """Byte offsets in `mjModel` (m_), its `opt` (o_) and `mjData` (d_)."""

    m_nsensor: int
    m_nv: int
    m_nbody: int
    m_neq: int
    m_nactuator: int
    m_nplugin: int
    o_timestep: int
    o_integrator: int
    o_disableflags: int
    m_qpos0: int
    m_jnt_qposadr: int
    m_jnt_dofadr: int
    m_dof_armature: int
    m_dof_invweight0: int
    m_body_parentid: int
    m_body_rootid: int
    m_body_weldid: int
    m_body_dofnum: int
    m_body_dofadr: int
    m_dof_parentid: int
    m_site_bodyid: int
    m_geom_bodyid: int
    m_geom_size: int
    m_tendon_adr: int
    m_tendon_num: int
    m_tendon_group: int
    m_tendon_width: int
    m_tendon_rgba: int
    m_tendon_limited: int
    m_tendon_range: int
    m_tendon_length0: int
    m_tendon_lengthspring: int
    m_tendon_stiffness: int
    m_tendon_stiffnesspoly: int
    m_tendon_damping: int
    m_tendon_dampingpoly: int
    m_tendon_actuatorid: int
    m_eq_type: int
    m_eq_obj1id: int
    m_eq_obj2id: int
    m_eq_data: int
    m_wrap_type: int
    m_wrap_objid: int
    m_wrap_prm: int
    m_actuator_trntype: int
    m_actuator_trnid: int
    m_actuator_gear: int
    m_actuator_plugin: int
    m_actuator_ctrladr: int
    m_actuator_outadr: int
    m_actuator_outnum: int
    m_actuator_ctrllimited: int
    m_actuator_ctrlrange: int
    m_actuator_forcelimited: int
    m_actuator_forcerange: int
    m_sensor_type: int
    m_sensor_objtype: int
    m_sensor_objid: int
    m_sensor_plugin: int
    m_sensor_adr: int
    m_sensor_dim: int
    m_sensor_datatype: int
    m_sensor_cutoff: int
    m_sensor_history: int
    m_sensor_historyadr: int
    m_sensor_delay: int
    m_sensor_interval: int
    m_plugin: int
    m_plugin_stateadr: int
    m_plugin_statenum: int
    m_plugin_attr: int
    m_plugin_attradr: int
    m_names: int
    m_name_jntadr: int
    m_name_tendonadr: int
    m_nnames: int
    m_numeric_adr: int
    m_numeric_size: int
    m_numeric_data: int
    m_nwrap: int
    m_ntendon: int
    m_njnt: int
    m_npluginattr: int
    d_time: int
    d_qpos: int
    d_qvel: int
    d_ctrl: int
    d_plugin_state: int
    d_geom_xpos: int
    d_geom_xmat: int
    d_ten_length: int
    d_ten_velocity: int
    d_ten_wrapadr: int
    d_ten_wrapnum: int
    d_wrap_obj: int
    d_wrap_xpos: int
    d_subtree_com: int
    d_cdof: int
    d_moment_rownnz: int
    d_moment_rowadr: int
    d_moment_colind: int
    d_actuator_moment: int
    d_qfrc_applied: int
    d_qfrc_bias: int
    d_qfrc_passive: int
    d_actuator_force: int
    d_sensordata: int
    d_site_xpos: int
    d_site_xmat: int
    d_cfrc_int: int
    d_cfrc_ext: int
    d_ne: int
    d_nf: int
    d_nefc: int
    d_efc_type: int
    d_efc_id: int
    d_efc_force: int
    d_history: int


EQ_DATA: Final[int] = mujoco.mjNEQDATA  # numbers of each equality

_OWNER = {"m": "mjModel", "o": "mjOption", "d": "mjData"}


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


def read_layout() -> Layout:
    """Offsets for the MuJoCo that is running.

    Raises:
        EngineError: a field is gone or has an unknown type.
    """
    option = mirror("mjModel").opt.offset
    offsets = {}
    for entry in Layout._fields:
        owner, name = entry.split("_", 1)
        member = getattr(mirror(_OWNER[owner]), name, None)
        if member is None:
            raise EngineError(
                f"mujoco {mujoco.__version__} has no {_OWNER[owner]}.{name}, which tendon-mj "
                "reads; versions that fit are named in its pyproject.toml"
            )
        offsets[entry] = member.offset + (option if owner == "o" else 0)
    return Layout(**offsets)


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


def verify(layout: Layout) -> None:
    """Hold the offsets against what the bindings show, on a model made for it.

    Raises:
        EngineError: names the first field that does not agree.
    """
    model = mujoco.MjModel.from_xml_string(_CANARY)
    data = mujoco.MjData(model)
    data.time = 0.625
    owners = {"m": (model, model), "o": (model, model.opt), "d": (data, data)}
    for entry, offset in layout._asdict().items():
        owner, name = entry.split("_", 1)
        holder, shower = owners[owner]
        _compare(holder._address + offset, getattr(shower, name, None), f"{_OWNER[owner]}.{name}")


def verify_state(layout: Layout, data: mujoco.MjData) -> None:
    """The one array that no model without our plugin fills.

    Raises:
        EngineError: it is not where the offsets say.
    """
    _compare(data._address + layout.d_plugin_state, data.plugin_state, "mjData.plugin_state")


def _compare(address: int, shown: object, name: str) -> None:
    if isinstance(shown, float):
        agrees = ctypes.c_double.from_address(address).value == shown
    elif isinstance(shown, bool):
        agrees = ctypes.c_bool.from_address(address).value == shown
    elif isinstance(shown, int):
        agrees = ctypes.c_int.from_address(address).value == shown
    elif not isinstance(shown, np.ndarray) or not shown.size:  # not shown, or empty here
        return
    else:
        held = ctypes.c_size_t.from_address(address).value
        # arrays that a struct holds itself, not by pointer, start at the address
        agrees = shown.ctypes.data in (held, address)
    if not agrees:
        raise EngineError(
            f"mujoco {mujoco.__version__}: {name} is not where its description says; tendon-mj "
            "will not touch memory that it may misread"
        )
