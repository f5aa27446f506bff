"""Drawing of a sheathed tendon into any scene: each span in the colour of its tension.

MuJoCo calls this function of the plugin for every scene that it fills, whether for a window, a
picture or a clip. It draws where the model has the custom numeric `tendon_mj.tension_scale`, whose
two numbers are the tensions [N] at the ends of the colour bar, and where MuJoCo itself would draw
the tendon. A sphere marks each guide over which the tendon slips.
"""

from __future__ import annotations

from typing import Any

import mujoco
from numba import types

from tendon_mj.compilation import apart, callback, compiled
from tendon_mj.plugin.abi.layout import Layout
from tendon_mj.plugin.abi.library import mjv_connector, mjv_initGeom
from tendon_mj.plugin.abi.memory import (
    byte,
    double,
    doubles,
    integer,
    local_doubles,
    pointer,
    set_integer,
    set_single,
    single,
)
from tendon_mj.plugin.abi.scene_layout import SceneLayout
from tendon_mj.plugin.sheath_plugin.attributes import is_sensor
from tendon_mj.plugin.sheath_plugin.binding.bind import is_bound
from tendon_mj.plugin.sheath_plugin.colours import SHADED, SLIPPING, VIRIDIS, colour_index
from tendon_mj.plugin.sheath_plugin.state import state_at, state_of, unpack
from tendon_mj.plugin.sheath_plugin.tension_scale import tension_scale
from tendon_mj.sheath import Guides
from tendon_mj.typing import FloatArray

THICKER = 1.25  # radius of a span over that of MuJoCo's own tendon, which it covers
_MARK = 4.0  # radius of a mark over that of MuJoCo's own tendon

_ends = local_doubles(6)
_TENDON = mujoco.mjtObj.mjOBJ_TENDON.value
_CAPSULE, _SPHERE = mujoco.mjtGeom.mjGEOM_CAPSULE.value, mujoco.mjtGeom.mjGEOM_SPHERE.value
_SHOWN = mujoco.mjtVisFlag.mjVIS_TENDON.value
_GROUPS = mujoco.mjNGROUP
_POINT = 24  # bytes


@compiled
def _is_hidden(layout: Layout, at: SceneLayout, m: int, option: int, tendon: int) -> bool:
    """Whether MuJoCo does not draw a tendon."""
    group = min(max(integer(pointer(m + layout.m_tendon_group), tendon), 0), _GROUPS - 1)
    shown = byte(option + at.v_flags, _SHOWN) and byte(option + at.v_tendongroup, group)
    return not shown or single(pointer(m + layout.m_tendon_rgba), 4 * tendon + 3) == 0.0


@compiled
def _new_geom(at: SceneLayout, scene: int) -> int:
    """Address of the scene's next geom, 0 and the scene's status where it is full."""
    count = integer(scene + at.s_ngeom, 0)
    if count >= integer(scene + at.s_maxgeom, 0):
        set_integer(scene + at.s_status, 1)
        return 0
    return pointer(scene + at.s_geoms) + at.geom_bytes * count


@compiled
def _add_geom(
    at: SceneLayout, scene: int, geom: int, tendon: int, red: float, green: float, blue: float
) -> None:
    """Make the geom that `_new_geom` gave part of the scene, as a part of a tendon."""
    set_single(geom + at.g_rgba, 0, SHADED * red)
    set_single(geom + at.g_rgba, 1, SHADED * green)
    set_single(geom + at.g_rgba, 2, SHADED * blue)
    set_single(geom + at.g_rgba, 3, 1.0)
    set_single(geom + at.g_emission, 0, 1.0 / SHADED)
    set_single(geom + at.g_specular, 0, 0.0)
    count = integer(scene + at.s_ngeom, 0)
    set_integer(geom + at.g_objtype, _TENDON)
    set_integer(geom + at.g_objid, tendon)
    set_integer(geom + at.g_segid, count)
    set_integer(scene + at.s_ngeom, count + 1)


@apart
def _draw_span(
    at: SceneLayout, scene: int, tendon: int, start: int, end: int, radius: float, colour: int
) -> None:
    """Draw a straight stretch between the points at two addresses."""
    a, b = doubles(start, 3), doubles(end, 3)
    if a[0] == b[0] and a[1] == b[1] and a[2] == b[2]:
        return
    geom = _new_geom(at, scene)
    if geom != 0:
        mjv_initGeom(geom, _CAPSULE, 0, 0, 0, 0)
        mjv_connector(geom, _CAPSULE, radius, start, end)
        red, green, blue = VIRIDIS[colour, 0], VIRIDIS[colour, 1], VIRIDIS[colour, 2]
        _add_geom(at, scene, geom, tendon, red, green, blue)


@apart
def _mark_guide(
    at: SceneLayout, scene: int, tendon: int, guides: Guides, i: int, where: int, radius: float
) -> None:
    """Mark a guide at an address's point if the tendon slips over it."""
    guide = guides[i]
    is_off = guide.is_on_arc != 0.0 and guide.angle == 0.0  # its geom is not touched
    if guide.flow == 0.0 or guide.is_pulley != 0.0 or is_off:
        return
    geom = _new_geom(at, scene)
    if geom != 0:
        mjv_initGeom(geom, _SPHERE, 0, where, 0, 0)
        for k in range(3):
            set_single(geom + at.g_size, k, radius)
        _add_geom(at, scene, geom, tendon, SLIPPING[0], SLIPPING[1], SLIPPING[2])


@compiled
def _put_between(point: FloatArray, a: FloatArray, b: FloatArray, share: float) -> None:
    """Write the point at a share of the way from a to b."""
    for k in range(3):
        point[k] = (1.0 - share) * a[k] + share * b[k]


@apart
def _draw_sheath(
    layout: Layout,
    at: SceneLayout,
    m: int,
    d: int,
    option: int,
    scene: int,
    address: int,
    low: float,
    high: float,
) -> None:
    """Draw the sheath whose state is at ``address``.

    The spans lie between the points of MuJoCo's own path. Between the two ends of an arc MuJoCo
    draws the chord; the guides on the arc, and the segments between them, share it.
    """
    state = state_at(address)
    tendon = int(state.tendon)
    if state.started == 0.0 or _is_hidden(layout, at, m, option, tendon):
        return
    segments, guides, _ = unpack(address)
    ea = state.law.axial_stiffness
    width = double(pointer(m + layout.m_tendon_width), tendon)
    radius, mark = THICKER * width, _MARK * width
    path = pointer(d + layout.d_wrap_xpos)
    path += _POINT * integer(pointer(d + layout.d_ten_wrapadr), tendon)
    spans = integer(pointer(d + layout.d_ten_wrapnum), tendon) - 1
    near, far = (0, _POINT) if state.input_at_last == 0.0 else (_POINT, 0)
    piece = _ends()
    first, second = doubles(piece, 3), doubles(piece + _POINT, 3)
    last, end = -1, 0  # segment whose span was drawn last, and where that ends
    for j in range(len(segments)):
        point = segments[j].point
        if not 0.0 <= point < spans:
            continue
        begin = path + _POINT * int(point) + near
        if last < 0:
            for i in range(j):
                _mark_guide(at, scene, tendon, guides, i, begin, mark)
        else:
            is_cut = False
            for i in range(last, j):
                is_cut |= guides[i].is_pulley != 0.0
            a, b, count = doubles(end, 3), doubles(begin, 3), j - last
            for i in range(last, j + 1):
                if is_cut:
                    break
                _put_between(first, a, b, max(0.0, (i - last - 0.5) / count))
                _put_between(second, a, b, min(1.0, (i - last + 0.5) / count))
                colour = colour_index(ea * segments[i].tension, low, high)
                _draw_span(at, scene, tendon, piece, piece + _POINT, radius, colour)
                if i < j:
                    _put_between(second, a, b, (i - last + 0.5) / count)
                    _mark_guide(at, scene, tendon, guides, i, piece + _POINT, mark)
        last, end = j, path + _POINT * int(point) + far
        colour = colour_index(ea * segments[j].tension, low, high)
        _draw_span(at, scene, tendon, begin, end, radius, colour)


def make_visualize(layout: Layout, at: SceneLayout) -> Any:
    """Bind the function of `mjpPlugin` that draws to the offsets of the running MuJoCo."""
    void, ptr, i32 = types.void, types.intp, types.int32

    @callback(void(ptr, ptr, ptr, ptr, i32))
    def visualize(m: int, d: int, option: int, scene: int, instance: int) -> None:
        low, high = tension_scale(layout, m)
        if not low < high or is_sensor(layout, m, instance):
            return
        if is_bound(layout, m, d, instance):
            address = state_of(layout, m, d, instance)
            _draw_sheath(layout, at, m, d, option, scene, address, low, high)

    return visualize
