"""Drawing of a sheathed tendon into any scene: each span in the colour of its tension.

MuJoCo calls this function of the plugin for every scene that it fills, whether for a window, a
picture or a clip. It draws where the model has the custom numeric `tendon_mj.tension_scale`, whose
two numbers are the tensions [N] at the ends of the colour bar, and where MuJoCo itself would draw
the tendon. A sphere marks each guide over which the tendon slips under tension.

The colours are viridis, of which equal steps look equal, also to colour-blind eyes. A geom of a
scene shows its colour as it is, so that it can be read off a colour bar, where only its own
emission lights it: `rgba` is dimmed to a thousandth and `emission` makes up for that.
"""

from __future__ import annotations

import mujoco
import numpy as np

from tendon_mj.errors import InvalidValueError
from tendon_mj.native import LocalDoubles, Text, apart, compiled, entry
from tendon_mj.plugin.abi.draft import Draft
from tendon_mj.plugin.abi.layout import Data, Model, Option, Scene
from tendon_mj.plugin.abi.library import C, mj_name2id, mjv_connector, mjv_initGeom
from tendon_mj.plugin.abi.memory import address_of, doubles
from tendon_mj.plugin.sheath_plugin.attributes import is_sensor
from tendon_mj.plugin.sheath_plugin.bind import is_bound
from tendon_mj.plugin.sheath_plugin.state import state_at, state_of, tension_unit, unpack
from tendon_mj.sheath import ROUNDING, Guides, Segments
from tendon_mj.typing import FloatArray

SHADED = 1e-3  # share of a colour that the scene's lights act on
SLIPPING = (0.90, 0.00, 0.48)  # magenta, which viridis does not have

_VIRIDIS = """
44015444025645045745055946075a46085c460a5d460b5e470d60470e61471063471164471365481467481668
48176948186a481a6c481b6d481c6e481d6f481f70482071482173482374482475482576482677482878482979
472a7a472c7a472d7b472e7c472f7d46307e46327e46337f463480453581453781453882443983443a83443b84
433d84433e85423f854240864241864142874144874045884046883f47883f48893e49893e4a893e4c8a3d4d8a
3d4e8a3c4f8a3c508b3b518b3b528b3a538b3a548c39558c39568c38588c38598c375a8c375b8d365c8d365d8d
355e8d355f8d34608d34618d33628d33638d32648e32658e31668e31678e31688e30698e306a8e2f6b8e2f6c8e
2e6d8e2e6e8e2e6f8e2d708e2d718e2c718e2c728e2c738e2b748e2b758e2a768e2a778e2a788e29798e297a8e
297b8e287c8e287d8e277e8e277f8e27808e26818e26828e26828e25838e25848e25858e24868e24878e23888e
23898e238a8d228b8d228c8d228d8d218e8d218f8d21908d21918c20928c20928c20938c1f948c1f958b1f968b
1f978b1f988b1f998a1f9a8a1e9b8a1e9c891e9d891f9e891f9f881fa0881fa1881fa1871fa28720a38620a486
21a58521a68522a78522a88423a98324aa8325ab8225ac8226ad8127ad8128ae8029af7f2ab07f2cb17e2db27d
2eb37c2fb47c31b57b32b67a34b67935b77937b87838b9773aba763bbb753dbc743fbc7340bd7242be7144bf70
46c06f48c16e4ac16d4cc26c4ec36b50c46a52c56954c56856c66758c7655ac8645cc8635ec96260ca6063cb5f
65cb5e67cc5c69cd5b6ccd5a6ece5870cf5773d05675d05477d1537ad1517cd2507fd34e81d34d84d44b86d549
89d5488bd6468ed64590d74393d74195d84098d83e9bd93c9dd93ba0da39a2da37a5db36a8db34aadc32addc30
b0dd2fb2dd2db5de2bb8de29bade28bddf26c0df25c2df23c5e021c8e020cae11fcde11dd0e11cd2e21bd5e21a
d8e219dae319dde318dfe318e2e418e5e419e7e419eae51aece51befe51cf1e51df4e61ef6e620f8e621fbe723
fde725
"""
VIRIDIS: FloatArray = np.frombuffer(bytes.fromhex(_VIRIDIS), np.uint8).reshape(-1, 3) / 255.0
_COUNT = len(VIRIDIS)


@compiled
def colour_index(tension: float, low: float, high: float) -> int:
    """Row of ``VIRIDIS`` for a tension on a colour bar from ``low`` to ``high`` [N], clipped.

    A tension that is not a number has the first colour.
    """
    share = (tension - low) / (high - low)
    if not share > 0.0:
        return 0
    return _COUNT - 1 if share >= 1.0 else int(share * _COUNT)


TENSION_SCALE = "tendon_mj.tension_scale"
_NUMERIC = mujoco.mjtObj.mjOBJ_NUMERIC.value
_name = Text(TENSION_SCALE)


@compiled
def tension_scale(m: Model) -> tuple[float, float]:
    """Tensions at the ends of the colour bar [N], both 0 if the model has none."""
    numeric = mj_name2id(m, _NUMERIC, _name())
    if numeric < 0 or m.numeric_size[numeric] < 2:
        return 0.0, 0.0
    start = m.numeric_adr[numeric]
    return m.numeric_data[start], m.numeric_data[start + 1]


def check_tension_scale(model: Draft) -> None:
    """Check the custom numeric, if the model has it.

    Raises:
        InvalidValueError: it is not two finite tensions, the lower one first.
    """
    numeric = C.mj_name2id(model.address, _NUMERIC, TENSION_SCALE.encode())
    if numeric < 0:
        return
    start, count = model.numeric_adr[numeric], model.numeric_size[numeric]
    check_limits(*model.numeric_data[start : start + count])


def check_limits(*limits: float) -> None:
    """Check the tensions at the ends of a colour bar.

    Raises:
        InvalidValueError: they are not two finite tensions, the lower one first.
    """
    if len(limits) != 2 or not -float("inf") < limits[0] < limits[1] < float("inf"):
        shown = " ".join(f"{limit:g}" for limit in limits)
        raise InvalidValueError(
            f"custom numeric {TENSION_SCALE!r} = {shown!r} must be two tensions [N], the lower one "
            "first"
        )


THICKER = 1.25  # radius of a span over that of MuJoCo's own tendon, which it covers
MARK = 1.3  # radius of a mark over that of a span, which it does not hide

_ends = LocalDoubles(6)
_TENDON = mujoco.mjtObj.mjOBJ_TENDON.value
_CAPSULE, _SPHERE = mujoco.mjtGeom.mjGEOM_CAPSULE.value, mujoco.mjtGeom.mjGEOM_SPHERE.value
_SHOWN = mujoco.mjtVisFlag.mjVIS_TENDON.value
_GROUPS = mujoco.mjNGROUP
_POINT = 24  # bytes


@compiled
def _is_hidden(m: Model, option: Option, tendon: int) -> bool:
    """Return whether MuJoCo does not draw a tendon."""
    group = min(max(m.tendon_group[tendon], 0), _GROUPS - 1)
    shown = option.flags[_SHOWN] and option.tendongroup[group]
    return not shown or m.tendon_rgba[tendon, 3] == 0.0


@compiled
def _has_room(scene: Scene) -> bool:
    """Return whether a scene has room for a geom; its status tells if it has not."""
    if scene.ngeom >= scene.maxgeom:
        scene.status = 1
        return False
    return True


@compiled
def _add_geom(scene: Scene, tendon: int, red: float, green: float, blue: float) -> None:
    """Make the geom behind those of the scene one of them, as a part of a tendon."""
    geom = scene.geoms[scene.ngeom]
    geom.rgba[0], geom.rgba[1], geom.rgba[2] = SHADED * red, SHADED * green, SHADED * blue
    geom.rgba[3] = 1.0
    geom.emission, geom.specular = 1.0 / SHADED, 0.0
    geom.objtype, geom.objid, geom.segid = _TENDON, tendon, scene.ngeom
    scene.ngeom += 1


@apart
def _draw_span(scene: Scene, tendon: int, start: int, end: int, radius: float, colour: int) -> None:
    """Draw a straight stretch between the points at two addresses."""
    a, b = doubles(start, 3), doubles(end, 3)
    if a[0] == b[0] and a[1] == b[1] and a[2] == b[2]:
        return
    if _has_room(scene):
        geom = scene.geoms[scene.ngeom]
        mjv_initGeom(geom, _CAPSULE, 0, 0, 0, 0)
        mjv_connector(geom, _CAPSULE, radius, start, end)
        red, green, blue = VIRIDIS[colour, 0], VIRIDIS[colour, 1], VIRIDIS[colour, 2]
        _add_geom(scene, tendon, red, green, blue)


@apart
def _mark_guide(
    scene: Scene,
    tendon: int,
    segments: Segments,
    guides: Guides,
    i: int,
    where: int,
    radius: float,
) -> None:
    """Mark a guide at an address's point if the tendon slips over it, unless it is slack there."""
    guide = guides[i]
    is_off = guide.is_on_arc != 0.0 and guide.angle == 0.0  # its geom is not touched
    is_off |= max(segments[i].tension, segments[i + 1].tension) <= ROUNDING
    if guide.flow == 0.0 or guide.is_pulley != 0.0 or is_off:
        return
    if _has_room(scene):
        geom = scene.geoms[scene.ngeom]
        mjv_initGeom(geom, _SPHERE, 0, where, 0, 0)
        for k in range(3):
            geom.size[k] = radius
        _add_geom(scene, tendon, SLIPPING[0], SLIPPING[1], SLIPPING[2])


@compiled
def _put_between(point: FloatArray, a: FloatArray, b: FloatArray, share: float) -> None:
    """Write the point at a share of the way from a to b."""
    for k in range(3):
        point[k] = (1.0 - share) * a[k] + share * b[k]


@apart
def _draw_sheath(
    m: Model,
    d: Data,
    option: Option,
    scene: Scene,
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
    if state.started == 0.0 or _is_hidden(m, option, tendon):
        return
    segments, guides, _ = unpack(address)
    ea = tension_unit(state)
    width = m.tendon_width[tendon]
    radius, mark = THICKER * width, MARK * THICKER * width
    path = address_of(d.wrap_xpos) + _POINT * d.ten_wrapadr[tendon]
    spans = d.ten_wrapnum[tendon] - 1
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
                _mark_guide(scene, tendon, segments, guides, i, begin, mark)
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
                _draw_span(scene, tendon, piece, piece + _POINT, radius, colour)
                if i < j:
                    _put_between(second, a, b, (i - last + 0.5) / count)
                    _mark_guide(scene, tendon, segments, guides, i, piece + _POINT, mark)
        last, end = j, path + _POINT * int(point) + far
        colour = colour_index(ea * segments[j].tension, low, high)
        _draw_span(scene, tendon, begin, end, radius, colour)


@entry("tendon_mj_sheath_visualize", "void(mjModel, mjData, mjvOption, mjvScene, i32)")
def visualize(m: Model, d: Data, option: Option, scene: Scene, instance: int) -> None:
    """`visualize` of `mjpPlugin`."""
    low, high = tension_scale(m)
    if not low < high or is_sensor(m, instance):
        return
    if is_bound(m, d, instance):
        address = state_of(m, d, instance)
        _draw_sheath(m, d, option, scene, address, low, high)
