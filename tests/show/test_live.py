"""A live simulation: moved as by `mj_step`, at the clock's pace, with live parameters."""

import mujoco
import numpy as np
import pytest

import tendon_mj
from tendon_mj.errors import (
    TendonError,
    UnknownNameError,
)
from tendon_mj.plugin import TENSION_SCALE
from tendon_mj.show.live import prepare
from tendon_mj.show.live.scene import first_view, look_from
from tendon_mj.show.live.session import LiveSimulation, repeated, run_in_real_time, stands_still
from tests.refusals import refusing
from tests.rigs import block_and_tackle
from tests.show.rigs import PULLED, TENSION, pulled


def written(tmp_path, *scale):
    """Path of the pulled model with friction, and a tension scale if one is given."""
    spec = mujoco.MjSpec.from_string(PULLED)
    tendon_mj.add_friction(spec, "t", friction=0.3)
    if scale:
        tendon_mj.show_tension(spec, *scale)
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
    prepared = prepare(written(tmp_path, 1.0, 7.0))
    assert (prepared.low, prepared.high) == (1.0, 7.0)


def test_a_model_without_sheaths_can_be_shown(tmp_path):
    path = tmp_path / "plain.xml"
    path.write_text(PULLED)
    prepared = prepare(str(path))
    assert (prepared.low, prepared.high) == (0.0, 0.0)
    prepared.simulation.advance(0.1)
    assert prepared.simulation.curves()[1].shape[1:] == (0, 2)


def test_a_model_that_does_not_move_has_a_reason(tmp_path):
    still = table(tmp_path, "time_s,pull_N\n0,0\n1,0\n")
    assert "stay as they are" in prepare(written(tmp_path), still).still
    model = mujoco.MjModel.from_xml_string("<mujoco/>")
    assert stands_still(model, lambda time: np.zeros(0), 1.0) == "the model has no actuator"


def test_unknown_motions_and_models_are_refused(tmp_path):
    with refusing(UnknownNameError, "did you mean 'press'"):
        prepare("finger", "pres")
    with refusing(UnknownNameError, "push_N"):
        prepare(written(tmp_path), table(tmp_path, "time_s,push_N\n0,0\n1,1\n"))
    path = tmp_path / "wrong.xml"
    path.write_text(PULLED.replace('site="c"', 'site="d"'))
    with refusing(TendonError, "wrong.xml"):
        prepare(str(path))


def test_a_motion_is_repeated_without_a_jump():
    drive = repeated(np.linspace(0.0, 1.0, 1001)[:, None], 0.001)
    values = np.array([drive(0.001 * k)[0] for k in range(4000)])
    assert np.abs(np.diff(values)).max() < 0.01
    assert values.max() == 1.0
    assert values[0] == values[1500] == 0.0


def test_the_first_view_is_that_of_the_model_s_first_camera():
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
        eye = scene.camera[0]
        seen.append([*eye.pos, *eye.forward, *eye.up, eye.frustum_top / eye.frustum_near])
    np.testing.assert_allclose(seen[0], seen[1], atol=1e-3)


def test_without_a_camera_the_whole_model_is_seen():
    camera = '<camera name="front" pos="0.5 -1.2 0.1" xyaxes="1 0 0 0 0 1" fovy="50"/>'
    model = mujoco.MjModel.from_xml_string(PULLED.replace(camera, ""))
    view = first_view(model)
    np.testing.assert_allclose(view.look_at, model.stat.center)
    assert np.linalg.norm(view.position - view.look_at) > 0.5 * model.stat.extent


def test_it_advances_as_mujoco_does():
    simulation = pulled(lambda time: np.array([TENSION * np.sin(time) ** 2])).simulation
    assert simulation.advance(0.4 * simulation.model.opt.timestep) == 0.0
    assert simulation.advance(0.5) == pytest.approx(0.5)
    other = mujoco.MjData(simulation.model)
    for _ in range(250):
        other.ctrl[0] = TENSION * np.sin(other.time) ** 2
        mujoco.mj_step(simulation.model, other)
    assert simulation.data.time == other.time
    assert np.array_equal(simulation.data.qpos, other.qpos)


def test_it_remembers_the_tensions_of_the_last_seconds():
    simulation = LiveSimulation(pulled().simulation.model, lambda t: np.array([TENSION]), 1.0)
    for _ in range(30):
        simulation.advance(0.1)
    times, tensions = simulation.curves()
    assert times[-1] == pytest.approx(simulation.data.time)
    assert 0.85 <= times[-1] - times[0] <= 1.0 + 1e-9
    assert tensions.shape == (len(times), 1, 2)
    view = tendon_mj.view_sheath(simulation.model, simulation.data, "t")
    np.testing.assert_array_equal(tensions[-1, 0], view.tension[[0, -1]])


def test_a_parameter_acts_while_it_runs_and_is_kept_by_a_reset():
    simulation = pulled().simulation
    for friction in (0.3, 0.0):
        simulation.set("t_sheath.friction", friction)
        simulation.advance(1.0)
        held = simulation.curves()[1][-1, 0, 1]
        assert held < 0.9 * TENSION if friction else held == pytest.approx(TENSION, rel=1e-6)
    simulation.reset()
    assert simulation.data.time == 0.0
    assert simulation.parameters["t_sheath.friction"] == 0.0
    assert len(simulation.curves()[0]) == 1


def test_another_pretension_resets_a_wound_tendon_and_nothing_else():
    model = tendon_mj.load_model("bench")
    simulation = LiveSimulation(model, lambda time: np.zeros(model.nu))
    simulation.advance(0.1)
    (sheath,) = simulation.tendons
    before, pose = simulation.curves()[1][-1, 0], simulation.data.qpos.copy()
    pretension = simulation.parameters[f"{sheath}.pretension"]
    simulation.set(f"{sheath}.friction", 0.07)
    simulation.set(f"{sheath}.pretension", 2.0 * pretension)
    assert np.array_equal(simulation.data.qpos, pose)
    assert simulation.parameters[f"{sheath}.friction"] == 0.07
    simulation.advance(0.1)
    assert (simulation.curves()[1][-1, 0] > 1.1 * before).all()  # the load has yielded meanwhile


def test_over_pulleys_the_ends_shown_are_those_of_the_branch_that_friction_acts_on():
    spec = mujoco.MjSpec.from_string(block_and_tackle())
    tendon_mj.add_friction(spec, "t", friction=0.2)
    simulation = LiveSimulation(spec.compile(), lambda time: np.array([-15.0]))
    simulation.advance(0.2)
    assert [*simulation.tendons.values()] == ["t, branch 1"]
    went_in, came_out = simulation.curves()[1][-1, 0]
    assert went_in == pytest.approx(15.0)
    assert came_out == pytest.approx(15.0 * np.exp(-0.2 * np.pi / 2.0), rel=0.02)


def test_the_twin_has_the_same_controls_and_no_friction():
    simulation = pulled(lambda time: np.array([TENSION * np.sin(time) ** 2])).simulation
    simulation.advance(0.3)
    simulation.compare(True)
    simulation.set("t_sheath.friction", 0.4)
    simulation.advance(1.0)
    assert simulation.twin.time == pytest.approx(simulation.data.time)
    assert np.array_equal(simulation.twin.ctrl, simulation.data.ctrl)
    of_twin, own = (
        tendon_mj.view_sheath(simulation.model, data, "t").tension
        for data in (simulation.twin, simulation.data)
    )
    assert of_twin[1] == pytest.approx(of_twin[0])
    assert own[1] < 0.9 * own[0]
    simulation.reset()
    assert simulation.twin.time == 0.0
    simulation.compare(False)
    assert simulation.twin is None


def test_a_hand_takes_over_until_a_motion_is_played():
    prepared = prepare("finger")
    simulation = prepared.simulation
    simulation.advance(0.5)
    kept = simulation.data.ctrl.copy()
    simulation.hold(1, 0.01)
    assert simulation.is_by_hand
    simulation.advance(0.5)
    kept[1] = 0.01
    assert np.array_equal(simulation.data.ctrl, kept)
    assert list(prepared.motions) == ["curl", "tap", "press", "hold"]
    simulation.play(*prepared.motions["press"]())
    simulation.advance(2.5)
    force = simulation.model.sensor("tip_force").adr[0]
    assert simulation.data.sensordata[force] > 1.0, "the object, which curl moves away, is there"


def test_a_function_of_the_user_moves_its_data_as_in_a_loop_without_a_view():
    model = pulled().simulation.model
    data, other = mujoco.MjData(model), mujoco.MjData(model)

    def policy(model, data):
        data.ctrl[0] = TENSION * np.cos(data.time) ** 2  # not 0 at first, as where it is evaluated

    def step(model, data):
        policy(model, data)
        mujoco.mj_step(model, data)

    for own, advances in ((policy, 1), (step, 2)):
        simulation = LiveSimulation(model, None, data=data, step=own)
        assert simulation.data is data
        simulation.advance(0.2)
        for _ in range(100):
            step(model, other)
        assert data.time == other.time == pytest.approx(0.2 * advances)
        assert np.array_equal(data.qpos, other.qpos)
        assert np.array_equal(data.plugin_state, other.plugin_state)


def test_an_unstable_simulation_is_refused():
    simulation = pulled(lambda time: np.array([1e12])).simulation
    with pytest.raises(TendonError, match="became unstable before"):
        simulation.advance(5.0)


def test_it_keeps_the_pace_of_the_clock_until_the_view_is_closed():
    simulation, left = pulled().simulation, iter([True] * 30 + [False])
    done = run_in_real_time(simulation, lambda: next(left))
    assert done.frames == 30
    assert done.simulated <= done.elapsed + simulation.model.opt.timestep
    assert done.simulated == pytest.approx(simulation.data.time)
    assert "× real time" in done.sentence()


def test_ctrl_c_ends_it_quietly_and_a_pause_stands_still():
    simulation, left = pulled().simulation, iter([True] * 4)
    simulation.paused = True

    def show():
        if next(left, None) is None:
            raise KeyboardInterrupt
        return True

    done = run_in_real_time(simulation, show)
    assert (done.simulated, done.elapsed, done.frames) == (0.0, 0.0, 3)
    assert simulation.data.time == 0.0


def test_the_time_of_a_view_goes_on_while_it_is_paused():
    simulation = pulled().simulation
    simulation.paused = True
    assert run_in_real_time(simulation, lambda: True, seconds=0.05).simulated == 0.0
