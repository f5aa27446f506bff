"""A MuJoCo with other structures is refused before any of its memory is touched."""

import mujoco
import pytest

from tendon_mj.errors import EngineError
from tendon_mj.plugin import loading
from tendon_mj.plugin.abi import layout as layouts
from tendon_mj.plugin.abi.layout import LAYOUT, SCENE, read, verify, verify_scene
from tendon_mj.sheath import record_type
from tests.refusals import refusing

OFFSETS, SCENE_OFFSETS = read(LAYOUT), read(SCENE)


def test_the_running_mujoco_is_as_described():
    verify(OFFSETS)
    loading._verify_struct()


@pytest.mark.parametrize(
    "field", ["m_tendon_num", "d_qpos", "d_cdof", "d_qfrc_passive", "o_timestep"]
)
@pytest.mark.parametrize("shift", [8, -8])
def test_a_wrong_offset_is_refused_by_name(field, shift):
    wrong = {**OFFSETS, field: OFFSETS[field] + shift}
    owner = {"m": "mjModel", "o": "mjOption", "d": "mjData"}[field[0]]
    with refusing(EngineError, mujoco.__version__, f"{owner}.{field[2:]}"):
        verify(wrong)


def test_a_field_that_is_gone_is_refused_by_name(monkeypatch):
    class Bare:
        opt = layouts.mirror("mjModel").opt

    mirrors = {"mjModel": Bare, "mjData": layouts.mirror("mjData")}
    monkeypatch.setattr(layouts, "mirror", lambda name: mirrors[name])
    with refusing(EngineError, "mjModel.nsensor"):
        read(LAYOUT)


def test_a_type_of_unknown_size_is_refused():
    with refusing(EngineError, "size"):
        layouts._ctype(object())


def test_a_plugin_structure_of_another_shape_is_refused(monkeypatch):
    monkeypatch.setattr(loading, "_MEMBERS", f"{loading._MEMBERS} sdf_something")
    with refusing(EngineError, "'sdf_aabb'], not as", "sdf_something"):
        loading._verify_struct()


def test_registering_twice_changes_nothing():
    assert loading.register() is loading.register()


def test_its_scene_is_as_described():
    verify_scene(SCENE_OFFSETS)


@pytest.mark.parametrize("field", [f for f in SCENE.names if f != "v_flags"])
@pytest.mark.parametrize("shift", [4, -4])
def test_a_wrong_offset_of_a_scene_is_refused_by_name(field, shift):
    wrong = {**SCENE_OFFSETS, field: SCENE_OFFSETS[field] + shift}
    with refusing(EngineError, mujoco.__version__, "mjv"):
        verify_scene(wrong)


def test_a_field_of_a_scene_that_is_gone_is_refused_by_name(monkeypatch):
    whole = layouts.mirror
    monkeypatch.setattr(
        layouts, "mirror", lambda name: object if name == "mjvScene" else whole(name)
    )
    with refusing(EngineError, "mjvScene.maxgeom"):
        read(SCENE)


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
