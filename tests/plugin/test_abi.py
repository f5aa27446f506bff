"""A MuJoCo with other structures is refused before any of its memory is touched."""

import mujoco
import numpy as np
import pytest

from tendon_mj.errors import EngineError
from tendon_mj.plugin import loading, registration
from tendon_mj.plugin.abi import layout as layouts
from tendon_mj.plugin.abi import releases
from tendon_mj.plugin.abi.layout import LAYOUT, SCENE, read, verify, verify_scene
from tendon_mj.plugin.sheath_plugin.forces import pull_segment
from tendon_mj.plugin.sheath_plugin.input_force import is_constrained
from tendon_mj.plugin.sheath_plugin.path import count_guides
from tendon_mj.plugin.sheath_plugin.state import tension_unit
from tendon_mj.plugin.sheath_plugin.wraps import trace_path
from tendon_mj.sheath import record_type
from tests.refusals import refusing
from tests.rigs import arm, sheath_view, started

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
    monkeypatch.setattr(registration, "MEMBERS", f"{registration.MEMBERS} sdf_something")
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


def test_the_same_function_runs_in_python_on_a_model_and_its_data():
    """Numbers, flags, rows, and arrays of two dimensions by one index, read and written."""
    model = arm()
    data = started(model, seed=1)
    mujoco.mj_forward(model, data)
    state, segments, guides, path = sheath_view(model, data, "sheath")
    force, at = np.zeros(model.nv), path.ravel().copy()
    for segment in segments:
        pull_segment(model, data, state, segment, tension_unit(state) * segment.tension, force)
    np.testing.assert_array_equal(force, data.qfrc_passive)
    angles, segments["length"], guides["angle"] = guides["angle"].copy(), 0.0, 0.0
    state.started = 0.0  # else nothing has moved
    trace_path(model, data, state, segments, guides, (), at, False)
    np.testing.assert_array_equal(guides["angle"], angles)
    tendon = model.tendon("tendon").id
    assert count_guides(model, tendon, 1, 0) == (state.guides, 0, 0)
    assert not is_constrained(model, tendon)
    model.tendon_limited[tendon] = True
    assert is_constrained(model, tendon)
