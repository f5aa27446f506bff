"""A MuJoCo with other structures is refused before any of its memory is touched."""

import mujoco
import numpy as np
import pytest
from numba import carray

from tendon_mj.compilation import compiled
from tendon_mj.errors import EngineError
from tendon_mj.plugin import plugin, read_layout
from tendon_mj.plugin.abi import layout as layouts
from tendon_mj.plugin.abi.layout import read_scene_layout, verify, verify_scene
from tendon_mj.plugin.abi.memory import record_at, records_pointer
from tendon_mj.sheath import SEGMENT, record_type
from tests.refusals import refusing

LAYOUT = read_layout()


def test_the_running_mujoco_is_as_described():
    verify(LAYOUT)
    plugin._verify_struct()


@pytest.mark.parametrize(
    "field", ["m_tendon_num", "d_qpos", "d_cdof", "d_qfrc_passive", "o_timestep"]
)
@pytest.mark.parametrize("shift", [8, -8])
def test_a_wrong_offset_is_refused_by_name(field, shift):
    wrong = LAYOUT._replace(**{field: getattr(LAYOUT, field) + shift})
    owner = {"m": "mjModel", "o": "mjOption", "d": "mjData"}[field[0]]
    with refusing(EngineError, mujoco.__version__, f"{owner}.{field[2:]}"):
        verify(wrong)


def test_a_field_that_is_gone_is_refused_by_name(monkeypatch):
    class Bare:
        opt = layouts.mirror("mjModel").opt

    mirrors = {"mjModel": Bare, "mjData": layouts.mirror("mjData")}
    monkeypatch.setattr(layouts, "mirror", lambda name: mirrors[name])
    with refusing(EngineError, "mjModel.nsensor"):
        read_layout()


def test_a_type_of_unknown_size_is_refused():
    with refusing(EngineError, "size"):
        layouts._ctype(object())


def test_a_plugin_structure_of_another_shape_is_refused(monkeypatch):
    fields = (*plugin._Plugin._fields_[:-1], ("sdf_something", plugin._Plugin._fields_[-1][1]))
    other = type("Other", (), {"_fields_": fields})
    monkeypatch.setattr(plugin, "_Plugin", other)
    with refusing(EngineError, "'sdf_aabb'], not as", "sdf_something"):
        plugin._verify_struct()


def test_registering_twice_changes_nothing():
    assert plugin.register() is plugin.register()


SCENE = read_scene_layout()


def test_its_scene_is_as_described():
    verify_scene(SCENE)


@pytest.mark.parametrize("field", [f for f in SCENE._fields if f != "v_flags"])
@pytest.mark.parametrize("shift", [4, -4])
def test_a_wrong_offset_of_a_scene_is_refused_by_name(field, shift):
    wrong = SCENE._replace(**{field: getattr(SCENE, field) + shift})
    with refusing(EngineError, mujoco.__version__, "mjv"):
        verify_scene(wrong)


def test_a_field_of_a_scene_that_is_gone_is_refused_by_name(monkeypatch):
    whole = layouts.mirror
    monkeypatch.setattr(
        layouts, "mirror", lambda name: object if name == "mjvScene" else whole(name)
    )
    with refusing(EngineError, "mjvScene.maxgeom"):
        read_scene_layout()


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


def test_what_compiled_code_writes_is_in_the_array():
    pair_at, segments_at = record_at(record_type(Pair)), records_pointer(SEGMENT)

    @compiled
    def write(pair, segments, count):
        pair_at(pair).inner.two = 7.0
        for j in range(count):
            carray(segments_at(segments), count)[j].tension = j

    pair, segments = np.zeros(3), np.zeros(4, SEGMENT)
    write(pair.ctypes.data, segments.ctypes.data, 4)
    np.testing.assert_array_equal(pair, [0.0, 0.0, 7.0])
    np.testing.assert_array_equal(segments["tension"], np.arange(4.0))
    assert not segments["length"].any()
