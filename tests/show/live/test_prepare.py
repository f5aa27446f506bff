"""A model is watched in motion, from its camera, in colours that its tensions fit between."""

import mujoco
import numpy as np
import pytest

import tendon_mj
from tendon_mj.errors import RecordingError, TendonError, UnknownNameError
from tendon_mj.plugin import TENSION_SCALE
from tendon_mj.show.live import prepare
from tendon_mj.show.live.first_view import first_view
from tendon_mj.show.live.in_motion import in_motion, repeated, stands_still
from tendon_mj.show.live.window import look_from
from tests.show.live.models import PULLED, TENSION, pulled


def written(tmp_path, **changes):
    spec = mujoco.MjSpec.from_string(PULLED)
    tendon_mj.add_friction(spec, "t", friction=0.3)
    if "scale" in changes:
        tendon_mj.show_tension(spec, *changes["scale"])
    spec.compile()
    path = tmp_path / "pulled.xml"
    path.write_text(spec.to_xml())
    return str(path)


def table(tmp_path, text):
    path = tmp_path / "motion.csv"
    path.write_text(text)
    return str(path)


def test_the_finger_moves_between_the_limits_of_its_colours():
    prepared = prepare("finger")
    assert not prepared.still
    start = prepared.simulation.data.qpos.copy()
    for _ in range(20):
        prepared.simulation.advance(0.1)
    assert np.abs(prepared.simulation.data.qpos - start).max() > 0.3
    tensions = prepared.simulation.curves()[1]
    assert prepared.low <= tensions.min()
    assert tensions.max() <= prepared.high < 3.0 * tensions.max()
    assert list(prepared.simulation.model.numeric(TENSION_SCALE).data) == [0.0, prepared.high]


def test_a_model_s_own_limits_are_kept(tmp_path):
    prepared = prepare(written(tmp_path, scale=(1.0, 7.0)))
    assert (prepared.low, prepared.high) == (1.0, 7.0)


def test_a_model_without_sheaths_can_be_watched_too(tmp_path):
    path = tmp_path / "plain.xml"
    path.write_text(PULLED)
    prepared = prepare(str(path))
    assert (prepared.low, prepared.high) == (0.0, 0.0)
    prepared.simulation.advance(0.1)
    assert prepared.simulation.curves()[1].shape[1:] == (0, 2)


def test_a_model_that_does_not_move_is_said_why(tmp_path):
    still = table(tmp_path, "time_s,pull_N\n0,0\n1,0\n")
    assert "controls stay at 0" in prepare(written(tmp_path), still).still
    model = mujoco.MjModel.from_xml_string("<mujoco/>")
    assert stands_still(model, lambda time: np.zeros(0), 1.0) == "it has no actuator"


def test_a_table_moves_any_model(tmp_path):
    motion = table(tmp_path, "time_s,pull_N\n0,0\n1,10\n2,0\n")
    prepared = prepare(written(tmp_path), motion)
    assert not prepared.still
    prepared.simulation.advance(0.5)
    assert prepared.simulation.data.ctrl[0] == pytest.approx(5.0, rel=0.02)
    assert prepared.high >= TENSION


def test_a_motion_that_is_none_is_refused(tmp_path):
    with pytest.raises(UnknownNameError, match="did you mean 'press'"):
        prepare("finger", "pres")
    with pytest.raises(RecordingError, match="Motions with a name, such as curl, are the finger's"):
        in_motion("bench", tendon_mj.load_model("bench"), "curl")
    with pytest.raises(UnknownNameError, match=r"column 'push_N': unknown actuator 'push'"):
        prepare(written(tmp_path), table(tmp_path, "time_s,push_N\n0,0\n1,1\n"))
    with pytest.raises(UnknownNameError, match="did you mean 'finger'"):
        prepare("fingr")


def test_a_model_that_does_not_compile_is_refused_with_its_name(tmp_path):
    path = tmp_path / "wrong.xml"
    path.write_text(PULLED.replace('site="c"', 'site="d"'))
    with pytest.raises(TendonError, match=r"wrong\.xml"):
        prepare(str(path))


def test_a_motion_begins_anew_without_a_jump():
    rows = np.linspace(0.0, 1.0, 1001)[:, None]
    drive = repeated(rows, 0.001)
    values = np.array([drive(0.001 * k)[0] for k in range(4000)])
    assert np.abs(np.diff(values)).max() < 0.01
    assert values.max() == 1.0
    assert values[0] == values[1500] == 0.0


def test_it_is_seen_as_the_model_s_first_camera_sees_it():
    model = pulled().simulation.model
    camera, data, scene = mujoco.MjvCamera(), mujoco.MjData(model), mujoco.MjvScene(model, 100)
    mujoco.mj_forward(model, data)
    seen = []
    for kind in ("first", "fixed"):
        if kind == "first":
            look_from(camera, model, first_view(model))
        else:
            camera.type, camera.fixedcamid = mujoco.mjtCamera.mjCAMERA_FIXED, 0
        mujoco.mjv_updateScene(model, data, mujoco.MjvOption(), None, camera, 7, scene)
        one = scene.camera[0]
        seen.append([*one.pos, *one.forward, *one.up, one.frustum_top / one.frustum_near])
    np.testing.assert_allclose(seen[0], seen[1], atol=1e-3)


def test_without_a_camera_the_whole_model_is_seen():
    model = mujoco.MjModel.from_xml_string(
        PULLED.replace('<camera name="front"', '<site name="f"').replace(
            'xyaxes="1 0 0 0 0 1" fovy="50"', ""
        )
    )
    view = first_view(model)
    np.testing.assert_allclose(view.look_at, model.stat.center)
    assert view.distance > 0.5 * model.stat.extent
