"""A MuJoCo with other structures is refused before any of its memory is touched."""

import mujoco
import pytest

from tendon_mj.errors import EngineError
from tendon_mj.plugin import loading
from tendon_mj.plugin.abi import layout as layouts
from tendon_mj.plugin.abi import releases
from tendon_mj.plugin.abi.layout import LAYOUT, SCENE, read, verify, verify_scene
from tendon_mj.sheath import record_type
from tests.refusals import refusing

OFFSETS, SCENE_OFFSETS = read(LAYOUT), read(SCENE)
PARTS = {"m": "mjModel", "o": "mjOption", "d": "mjData"}
FIELDS = [
    *((verify, OFFSETS, name) for name in ("m_tendon_num", "d_qpos", "d_cdof", "o_timestep")),
    *((verify_scene, SCENE_OFFSETS, name) for name in SCENE.names if name != "v_flags"),
]


def test_the_running_mujoco_is_as_described():
    verify(OFFSETS)
    verify_scene(SCENE_OFFSETS)
    loading._verify_struct()
    release, offsets = releases.running()
    assert releases.known()[release] == offsets


@pytest.mark.parametrize(("check", "offsets", "field"), FIELDS, ids=[field for *_, field in FIELDS])
@pytest.mark.parametrize("shift", [8, 4, -4, -8])
def test_a_wrong_offset_is_refused_by_name(check, offsets, field, shift):
    where = f"{PARTS[field[0]]}.{field[2:]}" if check is verify else "mjv"
    with refusing(EngineError, mujoco.__version__, where):
        check({**offsets, field: offsets[field] + shift})


class Bare:
    opt = layouts.mirror("mjModel").opt


@pytest.mark.parametrize(
    ("layout", "structure", "bare", "field"),
    [(LAYOUT, "mjModel", Bare, "nsensor"), (SCENE, "mjvScene", object, "maxgeom")],
)
def test_a_field_that_is_gone_is_refused_by_name(layout, structure, bare, field, monkeypatch):
    whole = layouts.mirror
    monkeypatch.setattr(layouts, "mirror", lambda name: bare if name == structure else whole(name))
    with refusing(EngineError, f"{structure}.{field}"):
        read(layout)


def test_a_type_of_unknown_size_is_refused():
    with refusing(EngineError, "size"):
        layouts._ctype(object())


def test_a_plugin_structure_of_another_shape_is_refused(monkeypatch):
    monkeypatch.setattr(loading, "_MEMBERS", f"{loading._MEMBERS} sdf_something")
    with refusing(EngineError, "'sdf_aabb'], not as", "sdf_something"):
        loading._verify_struct()


def test_registering_twice_changes_nothing():
    assert loading.register() is loading.register()


class Pair:
    law: float
    inner: "Inner"


class Inner:
    one: float
    two: float


def test_fields_follow_one_another_without_gaps():
    assert record_type(Inner).names == ("one", "two")
    assert record_type(Pair).itemsize == 3 * 8
    assert record_type(Pair).fields["inner"][1] == 8
