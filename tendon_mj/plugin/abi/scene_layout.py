"""Where the fields that we write lie inside `mjvScene` and `mjvGeom`, and those of `mjvOption`.

As for `mjModel` and `mjData`, the offsets come from `mujoco.introspect`, and `verify_scene` holds
them against what the Python bindings show of structures made for it.
"""

from __future__ import annotations

import ctypes
from typing import Any, NamedTuple

import mujoco

from tendon_mj.errors import EngineError
from tendon_mj.plugin.abi.layout import mirror


class SceneLayout(NamedTuple):
    """Byte offsets in `mjvScene` (s_), `mjvGeom` (g_) and `mjvOption` (v_)."""

    s_maxgeom: int
    s_ngeom: int
    s_geoms: int
    s_status: int
    g_objtype: int
    g_objid: int
    g_segid: int
    g_size: int
    g_pos: int
    g_rgba: int
    g_emission: int
    g_specular: int
    v_tendongroup: int
    v_flags: int
    geom_bytes: int  # from one `mjvGeom` to the next


_OWNER = {"s": "mjvScene", "g": "mjvGeom", "v": "mjvOption"}
_STRIDE = "geom_bytes"
_SCENE = "<mujoco><worldbody><geom size='.1'/><geom size='.1'/></worldbody></mujoco>"


def read_scene_layout() -> SceneLayout:
    """Offsets for the MuJoCo that is running.

    Raises:
        EngineError: a field is gone or has an unknown type.
    """
    offsets = {_STRIDE: ctypes.sizeof(mirror("mjvGeom"))}
    for entry in SceneLayout._fields:
        if entry != _STRIDE:
            owner, name = entry.split("_", 1)
            member = getattr(mirror(_OWNER[owner]), name, None)
            if member is None:
                raise EngineError(
                    f"mujoco {mujoco.__version__} has no {_OWNER[owner]}.{name}, which tendon-mj "
                    "draws by; versions that fit are named in its pyproject.toml"
                )
            offsets[entry] = member.offset
    return SceneLayout(**offsets)


def verify_scene(layout: SceneLayout) -> None:
    """Hold the offsets against what the bindings show, on a scene made for it.

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
    # each begins where an array that the bindings show as memory says, less where that lies in it
    start = {
        "s": scene.flags.ctypes.data - mirror("mjvScene").flags.offset,
        "g": first.pos.ctypes.data - layout.g_pos,
        "v": option.flags.ctypes.data - layout.v_flags,
    }
    shown = {"s": scene, "g": first, "v": option}
    for entry, offset in layout._asdict().items():
        if entry == _STRIDE:
            agrees = second.pos.ctypes.data - first.pos.ctypes.data == offset
        elif entry == "s_geoms":
            agrees = ctypes.c_size_t.from_address(start["s"] + offset).value == start["g"]
        else:
            owner, name = entry.split("_", 1)
            agrees = _agrees(start[owner] + offset, getattr(shown[owner], name))
        if not agrees:
            owner, _, name = entry.partition("_")
            field = "the size of mjvGeom" if entry == _STRIDE else f"{_OWNER[owner]}.{name}"
            raise EngineError(
                f"mujoco {mujoco.__version__}: {field} is not as its description says; tendon-mj "
                "will not write where it may damage memory"
            )


def _agrees(address: int, shown: Any) -> bool:
    if isinstance(shown, int):
        return ctypes.c_int.from_address(address).value == shown
    if isinstance(shown, float):
        return ctypes.c_float.from_address(address).value == shown
    return bool(shown.ctypes.data == address)
