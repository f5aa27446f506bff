"""Failures while a simulation runs are counted and survived; models compile in many threads."""

import sys
import threading
from concurrent.futures import ThreadPoolExecutor

import mujoco
import numpy as np
import pytest

from tendon_mj import add_friction
from tendon_mj.errors import INTERRUPTED
from tendon_mj.plugin import advice
from tests.plugin.test_refusals import LAW as FLEXOR
from tests.plugin.test_refusals import compiled
from tests.refusals import refusing, silent
from tests.rigs import (
    fixed_sheaths,
    instance,
    pulled_xml,
    rope,
    run,
    servo_model,
    simulated,
    tendon_total,
    unpacked,
    warnings_of_ours,
)


@pytest.fixture(autouse=True)
def in_a_folder_of_its_own(tmp_path, monkeypatch):
    """MuJoCo writes its warnings to a file where it runs."""
    monkeypatch.chdir(tmp_path)


LAW = {"guides": 6, "bend": 2.0, "friction": 0.2, "pretension": 20.0}
UNSOLVED = ("input_tension", "output_tension", "unsolved")


def reeled():
    model = fixed_sheaths([LAW | {"sensors": UNSOLVED}])
    data = mujoco.MjData(model)
    run(model, data, 10)
    return model, data


def unsolved(data):
    return data.sensor("unsolved").data[0]


@pytest.fixture
def told():
    """Warnings of ours that MuJoCo was given; its own are of the control."""
    with warnings_of_ours() as messages:
        yield messages


@pytest.mark.parametrize(("control", "count"), [(20.0, 1), (-20.0, 0), (0.0, 0)])
def test_a_motor_that_pushes_its_tendon_is_told_of_once_by_a_finished_step(control, count, told):
    text = pulled_xml().replace(' gear="-1"', "")
    model = add_friction(mujoco.MjSpec.from_string(text), "t", friction=0.1).compile()
    data = mujoco.MjData(model)
    data.ctrl[0] = control
    mujoco.mj_forward(model, data)
    assert not told, "an evaluation may be one of a finite difference"
    for _ in range(2):
        data.ctrl[0] = control
        run(model, data, 3)
        mujoco.mj_resetData(model, data)
    assert ["is pushed by a motor" in message for message in told] == [True] * count


@pytest.mark.parametrize("control", [np.nan, np.inf, -np.inf])
def test_a_control_that_is_no_number_is_counted_told_once_and_moves_nothing(control, told):
    model, data = reeled()
    before = data.sensordata[:2].copy()
    stored = unpacked(model, data, "sheath0")[1].copy()
    for resets in (1, 2):
        data.ctrl[0] = control
        run(model, data, 5)
        assert unsolved(data) == 5
        assert len(told) == resets
        assert "sheath 'sheath0' was not solved" in told[-1]
        assert np.isfinite(data.plugin_state).all()
        np.testing.assert_array_equal(unpacked(model, data, "sheath0")[1], stored)
        data.ctrl[0] = 0.0
        run(model, data, 5)
        assert unsolved(data) == 5
        np.testing.assert_allclose(data.sensordata[:2], before, rtol=1e-9)
        mujoco.mj_resetData(model, data)
        run(model, data, 10)
        assert len(told) == resets


def test_a_reference_that_is_not_a_number_leaves_a_servo_s_motor_alone():
    model = servo_model(friction=0.3, velocity_gain=0.3)
    data = simulated(model, 10, ctrl=35.0)
    for control in (np.nan, 35.0):
        data.ctrl[0] = control
        mujoco.mj_step(model, data, 10)
        assert np.isfinite(data.qpos).all()
    assert np.isfinite(data.plugin_state).all()


def test_what_was_only_looked_at_does_not_come_true_instead():
    model, data = reeled()
    stored = unpacked(model, data, "sheath0")[1].copy()
    data.ctrl[0] = 1e-3
    mujoco.mj_forward(model, data)
    data.ctrl[0] = np.nan
    mujoco.mj_step(model, data)
    data.ctrl[0] = 0.0
    run(model, data, 2)
    kept = unpacked(model, data, "sheath0")[1]
    np.testing.assert_allclose(kept["stored"], stored["stored"], rtol=1e-12)


@pytest.mark.parametrize("control", [0.6, 1e3, 1e300])
def test_winding_in_more_than_there_is_is_counted_and_undone_by_winding_back_or_a_reset(control):
    model, data = reeled()
    total = tendon_total(model, data, "sheath0")
    data.ctrl[0] = control
    run(model, data, 5)
    assert unsolved(data) >= 5
    assert np.isfinite(data.plugin_state[: unpacked(model, data, "sheath0")[0].size]).all()
    if control < 1.0:
        data.ctrl[0] = 0.0
        run(model, data, 5)
        count = unsolved(data)
        run(model, data, 5)
        assert unsolved(data) == count
        assert tendon_total(model, data, "sheath0") == pytest.approx(total, rel=1e-12)
    mujoco.mj_resetData(model, data)
    run(model, data, 10)
    assert unsolved(data) == 0
    assert tendon_total(model, data, "sheath0") == pytest.approx(total, rel=1e-15)
    np.testing.assert_allclose(data.sensordata[:2], 20.0, rtol=1e-9)


@pytest.mark.parametrize("drag", [{"viscous_friction": 1e-6}, {"tendon_mass": 1e-12}])
@pytest.mark.parametrize("wound", [0.01, 0.1, 0.3, 0.45])
def test_next_to_no_drag_is_as_none_also_where_the_mount_yields_more_than_a_stretch(drag, wound):
    law = LAW | {"sheath_compliance": 1e-5, "sensors": UNSOLVED}
    readings = []
    for more in ({}, drag):
        model = fixed_sheaths([law | more])
        data = run(model, mujoco.MjData(model), 10)
        data.ctrl[0] = wound
        readings.append(run(model, data, 3).sensordata.copy())
    np.testing.assert_allclose(readings[1], readings[0], rtol=1e-3)


@pytest.mark.parametrize("more", [{}, {"viscous_friction": 1.0}, {"sheath_compliance": 1e-5}])
def test_no_sensor_reads_a_tension_without_bounds_that_is_not_counted_and_told(more, told):
    model = fixed_sheaths([LAW | {"sensors": UNSOLVED} | more])
    data = run(model, mujoco.MjData(model), 10)
    for step in range(40):
        data.ctrl[0] = 0.02 * step  # to more than the tendon of 0.5 m
        mujoco.mj_step(model, data)
        if not np.isfinite(data.sensordata).all():
            assert unsolved(data) > 0
            assert len(told) == 1
    data.ctrl[0] = 0.0
    assert np.isfinite(run(model, data, 5).sensordata).all()


@pytest.mark.filterwarnings("ignore::tendon_mj.TendonWarning")
@pytest.mark.parametrize("pretension", [0.0, 20.0])
def test_more_friction_than_a_number_can_say_holds_as_any_that_holds(pretension):
    readings = []
    for friction in (100.0, 1e6):  # on a bend of 1/3 rad, e^33 and what no number holds
        law = LAW | {"friction": friction, "pretension": pretension, "sensors": UNSOLVED}
        model = fixed_sheaths([law])
        data, shown = mujoco.MjData(model), []
        for wound in (0.0, 1e-4, 3e-4, -1e-3, -0.02, 2e-4):  # taut, slack and taut again
            data.ctrl[0] = wound
            shown.append(run(model, data, 3).sensordata.copy())
        assert unsolved(data) == 0
        assert np.isfinite(data.plugin_state).all()
        readings.append(shown)
    np.testing.assert_allclose(*readings, rtol=1e-12, atol=1e-9)  # N


@pytest.mark.parametrize("repeats", [1, 2, 3])
def test_a_corner_given_more_than_once_still_bends_the_tendon_once(repeats):
    corner = [[1.0, 0.0, 0.0]] * repeats
    law = {"points": [[0.0, 0.0, 0.0], *corner, [1.0, 1.0, 0.0]], "sensors": ("bend_angle",)}
    model = fixed_sheaths([law | {"friction": 0.2, "pretension": 10.0}])
    assert simulated(model).sensordata.sum() == pytest.approx(np.pi / 2)


def test_a_muscle_s_length_range_is_found_without_a_warning():
    """MuJoCo steps a model without passive forces to find it."""
    spec = mujoco.MjSpec.from_string(
        rope(
            "a 0 0 .05",
            "b .02 0 .03; c .1 0 .03",
            body='pos=".1 0 0"',
            joint='axis="0 1 0" range="-60 60" damping=".05"',
            geom='size=".02" fromto="0 0 0 .2 0 0" type="capsule"',
            actuator='<muscle tendon="t" force="20"/>',
        )
    )
    add_friction(spec, "t", friction=0.1, extra_bend=1.0, inner_guides=2)
    with silent():
        model = spec.compile()
    low, high = model.actuator_lengthrange[0]
    assert low + 0.01 < model.tendon_length0[0] < high - 0.01


THREADS, TIMES = 4, 50


def test_each_thread_is_told_of_its_own_model():
    start = threading.Barrier(THREADS)

    def compile_repeatedly(thread):
        start.wait()
        for _ in range(TIMES):
            with refusing(ValueError, f"instance 'bad{thread}': unknown tendon 'none{thread}'"):
                compiled(instance(f"bad{thread}", **(FLEXOR | {"tendon": f"none{thread}"})))
        return thread

    interval = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    try:
        with ThreadPoolExecutor(THREADS) as pool:
            done = list(pool.map(compile_repeatedly, range(THREADS)))
    finally:
        sys.setswitchinterval(interval)
    assert done == list(range(THREADS))


def test_ctrl_c_while_a_model_compiles_refuses_it_in_one_line(monkeypatch, capfd):
    def press(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(advice, "check_tension_scale", press)
    with pytest.raises(ValueError, match=INTERRUPTED):
        fixed_sheaths([LAW])
    assert capfd.readouterr().err == ""
    monkeypatch.undo()
    fixed_sheaths([LAW])
