"""Laws of many simulations at once: each is a replay, whoever runs beside it."""

from __future__ import annotations

import dataclasses

import mujoco
import numpy as np
import pytest

from tendon_mj.errors import InvalidValueError, RecordingError, TendonError, UnknownNameError
from tendon_mj.lab.recordings import Measured, Uncertain
from tendon_mj.lab.replay import (
    Adjustable,
    Simulator,
    reading_unit,
    replay_recording,
    suppress_unsolved_warnings,
)
from tendon_mj.lab.units import UNKNOWN
from tendon_mj.models import Bench, build_bench, load_model, model_path
from tests.lab.recorded import recorded
from tests.lab.replay.rigs import bench_recording, joint_recording
from tests.refusals import refusing
from tests.rigs import lever

RECORDINGS = [
    bench_recording(0.1, name="short"),
    bench_recording(0.3, 35.0, uncertain={"sheath.friction": Uncertain(0.2, 0.0, 0.5)}),
    bench_recording(0.2, 50.0, known={"sheath.pretension": 30.0, "input_tension.offset": 0.5}),
]
WOUND_IN = {"reel.command_scale": 1e3}  # more than there is of the tendon
SETS: list[dict[str, float]] = [
    {},
    {"sheath.friction": 0.05, "environment.stiffness": 2e4},
    {"sheath.friction": 0.05, "environment.stiffness": 2e4, "input_tension.delay": 0.003},
    {"output_tension.lag": 0.01, "reel.command_scale": 0.5, "gravity.x": -3.0},
    {"environment.armature": 0.3, "sheath.axial_stiffness": 1.5e4},
]


def same(a, b):
    return a.keys() == b.keys() and all(np.array_equal(a[c], b[c]) for c in a)


@pytest.mark.parametrize("threads", [1, 2, 5])
def test_every_simulation_is_a_replay_to_the_bit_on_any_number_of_threads(threads):
    answers = Simulator(RECORDINGS, threads=threads)(SETS)
    assert len(answers) == len(SETS)
    assert Simulator(RECORDINGS)([]) == []
    for given, row in zip(SETS, answers, strict=True):
        for recording, series in zip(RECORDINGS, row, strict=True):
            told = replay_recording(recording, parameters=given)
            assert same(series, {c: told.columns[c] for c in recording.measured})


def test_who_else_is_in_the_call_shows_in_no_number():
    simulator = Simulator(RECORDINGS, threads=2)
    together = simulator(SETS)
    for given, row in zip(SETS, together, strict=True):
        assert all(same(a, b) for a, b in zip(simulator([given])[0], row, strict=True))


def test_a_model_of_ones_own_is_used_and_stays_as_it_was():
    model = build_bench(Bench(friction=0.3)).compile()
    before = model.jnt_stiffness.copy(), model.opt.timestep, model.opt.disableflags
    recording = bench_recording()
    answer = Simulator([recording], model)([{"environment.stiffness": 2e4}])[0][0]
    assert (model.jnt_stiffness == before[0]).all()
    assert (model.opt.timestep, model.opt.disableflags) == before[1:]
    other = replay_recording(recording, model, parameters={"environment.stiffness": 2e4})
    assert same(answer, {c: other.columns[c] for c in recording.measured})


def test_what_a_recording_knows_can_be_left_out():
    simulator = Simulator(RECORDINGS[1:], described=False)
    plain = [dataclasses.replace(r, known={}, uncertain={}) for r in RECORDINGS[1:]]
    assert all(map(same, simulator([{}])[0], Simulator(plain)([{}])[0]))
    assert simulator.parameters["sheath.friction"].value == 0.15


def test_a_longer_step_can_be_asked_for():
    recording = bench_recording()  # samples every 2 ms, the model's step is 0.5 ms
    coarse = Simulator([recording], timestep=0.001)([{}])[0][0]
    model = load_model("bench")
    model.opt.timestep = 0.001
    told = replay_recording(recording, model)
    assert same(coarse, {c: told.columns[c] for c in recording.measured})


def test_the_same_simulator_in_other_steps():
    own = Simulator(RECORDINGS, threads=1)
    double = own.in_steps(2.0)
    assert same(double([SETS[1]])[0][1], Simulator(RECORDINGS, timestep=0.001)([SETS[1]])[0][1])
    assert same(double.in_steps(0.5)([SETS[1]])[0][1], own([SETS[1]])[0][1])
    assert double.steps == pytest.approx(0.5 * own.steps, rel=0.01)
    assert own.in_steps(100.0).steps < own.in_steps(4.0).steps + 3  # no longer than a sample


UNEVEN = np.cumsum(np.random.default_rng(0).uniform(0.005, 0.02, 60))


@pytest.mark.parametrize("recordings", [RECORDINGS, [joint_recording()], [joint_recording(UNEVEN)]])
def test_simulations_may_end_before_the_recordings_do(recordings):
    own, samples = Simulator(recordings), [r.time.size // 3 for r in recordings]
    sets = [given for given in SETS if given.keys() <= own.parameters.keys()]
    sets.append(dict.fromkeys([n for n in own.parameters if n.endswith(("delay", "lag"))], 0.007))
    shorter = own.up_to(samples)
    for whole, part in ((own, shorter), (own.in_steps(2.0), shorter.in_steps(2.0))):
        assert part.steps < 0.9 * whole.steps  # of which settling is a part
        for row, short in zip(whole(sets), part(sets), strict=True):
            for count, a, b in zip(samples, row, short, strict=True):
                assert same(*({c: s[:count] for c, s in series.items()} for series in (a, b)))
                assert all(s.shape == a[c].shape for c, s in b.items())


def test_contacts_are_simulated_where_there_can_be_any():
    time = np.arange(0.0, 0.2, 0.01)
    recording = recorded(time, {}, {"height_m": "height"}, "ball")
    ball = mujoco.MjModel.from_xml_string(
        "<mujoco><worldbody><geom type='plane' size='1 1 1'/><body pos='0 0 0.12'>"
        "<joint name='z' type='slide' axis='0 0 1'/><geom size='0.1'/></body></worldbody>"
        "<sensor><jointpos name='height' joint='z'/></sensor></mujoco>"
    )
    (series,) = Simulator([recording], ball)([{}])[0]
    assert series["height_m"].min() > -0.03
    falls = Simulator([recording], ball)([{"gravity.z": 0.0}])[0][0]
    assert np.abs(falls["height_m"]).max() < 1e-9


# failing


WILD = {"joint.stiffness": 1e6}  # on 10 g cm²: no step is short enough


def test_a_simulation_that_fails_is_nan_and_the_others_are_not(monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    failed, sound = Simulator([joint_recording()], threads=2)([WILD, {}])
    assert np.isnan(failed[0]["joint_rad"]).all()
    assert failed[0]["joint_rad"].shape == (50,)
    assert np.isfinite(sound[0]["joint_rad"]).all()
    assert not list(tmp_path.iterdir())  # MuJoCo's log


@pytest.mark.parametrize("strict", [False, True])
def test_steps_are_not_timed_until_the_simulations_end(strict):
    simulator, calls = Simulator(RECORDINGS, strict=strict), []
    mujoco.set_mjcb_time(lambda: float(len(calls.append("") or calls)))
    try:
        simulator([{}])
        assert not calls
        model = build_bench(Bench()).compile()
        mujoco.mj_step(model, mujoco.MjData(model))
        assert calls
    finally:
        mujoco.set_mjcb_time(None)


def test_a_strict_simulator_says_what_failed_when(monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    with refusing(TendonError, "'made up'", "'joint'"):
        Simulator([joint_recording()], strict=True)([{}, WILD])


def test_a_tendon_that_found_no_equilibrium_is_told_of_once_a_call():
    with pytest.warns(RuntimeWarning, match="sheath 'sheath' found no equilibrium") as warned:
        answers = Simulator(RECORDINGS)([WOUND_IN, {}])
    assert len(warned) == 1
    assert np.isfinite(answers[1][0]["input_tension_N"]).all()


def test_that_is_not_told_of_values_that_are_only_tried():
    with suppress_unsolved_warnings():  # a warning fails a test
        Simulator(RECORDINGS)([WOUND_IN, {}])
    with pytest.warns(RuntimeWarning, match="found no equilibrium"):
        Simulator(RECORDINGS)([WOUND_IN])


@pytest.mark.parametrize("threads", [1, 2])
def test_a_parameter_that_is_not_or_is_out_of_range_is_refused(threads):
    simulator = Simulator(RECORDINGS, threads=threads)
    with refusing(UnknownNameError, "did you mean 'sheath.friction'"):
        simulator([{}, {"sheath.fricton": 0.1}])
    with refusing(InvalidValueError, "sheath", "friction = -0.1"):
        simulator([{}, {"sheath.friction": -0.1}])
    with refusing(InvalidValueError, "input_tension.lag = -0.1"):
        simulator([{"input_tension.lag": -0.1}])


def test_what_makes_no_simulator_is_refused():
    with refusing(RecordingError, "0 recordings"):
        Simulator([])
    with refusing(RecordingError, "'bench', 'joint'"):
        Simulator([bench_recording(), joint_recording()])
    with refusing(RecordingError, "'pull'", "[known]", "'sheath.friction'"):
        Simulator([bench_recording(known={"sheath.fricton": 0.1})])
    with refusing(RecordingError, "'pull'", "friction", "-1"):
        Simulator([bench_recording(known={"sheath.friction": -1.0})])
    with refusing(RecordingError, "[recording]"):
        Simulator(RECORDINGS[0])  # type: ignore[arg-type]
    for wrong in ({"timestep": 0.0}, {"settle": -1.0}, {"threads": 0}):
        with refusing(InvalidValueError, *wrong):
            Simulator([bench_recording()], **wrong)


# what it says of itself


def test_parameters_are_those_that_the_simulations_have():
    simulator = Simulator(RECORDINGS)
    assert simulator.parameters["sheath.friction"][:3] == (0.2, "-", "live")
    assert simulator.parameters["sheath.pretension"][:3] == (30.0, "N", "live")
    assert simulator.parameters["environment.stiffness"][:3] == (1e4, "N/m", "joint")
    assert simulator.parameters["input_tension.offset"][:3] == (0.5, "N", "sensor")
    assert simulator.parameters["input_tension.drift"][:3] == (0.0, "N/s", "sensor")
    assert simulator.parameters["reel.command_offset"][:3] == (0.0, "m", "actuator")
    assert simulator.parameters["sheath.friction"].low == 0.0
    assert simulator.parameters["gravity.z"][:3] == (0.0, "m/s²", "gravity")
    model = {name: p.value for name, p in Simulator(RECORDINGS[:1]).parameters.items()}
    plain, said = Simulator(RECORDINGS[:1])([{}, model])
    assert same(plain[0], said[0])


def test_a_command_s_offset_is_in_the_control_s_unit_whatever_the_column_s():
    recording = bench_recording()
    (column, actuator), *_ = recording.driven
    angle = dataclasses.replace(
        recording,
        columns={**recording.columns, "spool_rad": recording.columns[column] / 0.01},
        drive={"spool_rad": actuator},
        known={**recording.known, f"{actuator}.command_scale": 0.01},
    )
    assert Simulator([angle]).parameters[f"{actuator}.command_offset"].unit == "m"


def test_it_names_what_the_model_has_and_what_the_recordings_use():
    simulator = Simulator(RECORDINGS)
    assert simulator.sheaths == ["sheath"]
    assert simulator.joints == {"environment": False, "sensor": False}
    assert simulator.inputs == {"input_displacement_m": ("reel", "m")}
    assert simulator.sensors["output_tension_N"] == ("output_tension", "N")
    assert Simulator([joint_recording()]).joints == {"joint": False, "spool": True}


@pytest.mark.parametrize(
    ("actuator", "sensor", "column", "prescribed"),
    [
        ("motor", "<clock name='read'/>", "read_rad", False),
        ("position", "<clock name='read'/>", "read_rad", True),
        ("position", "<jointpos name='read' joint='hinge'/>", "read_rad", False),
        ("position", "<actuatorfrc name='read' actuator='drive'/>", "read_Nm", False),
    ],
)
def test_only_a_servo_prescribes_a_motion_that_nobody_measured(
    actuator, sensor, column, prescribed
):
    model = mujoco.MjModel.from_xml_string(
        lever(
            f"<{actuator} name='drive' joint='hinge'/>",
            sensor,
            joint='name="hinge"',
            body='name="link"',
        )
    )
    time = np.arange(0.0, 0.2, 0.01)
    recording = recorded(time, {"drive_m": ("drive", 0.0 * time)}, {column: "read"}, "hinge")
    assert Simulator([recording], model).joints == {"hinge": prescribed}


@pytest.mark.parametrize(
    ("actuator", "unit"),
    [
        ("<position name='drive' joint='hinge'/>", "N m"),
        ("<motor name='drive' joint='hinge' gear='0.01'/>", UNKNOWN),  # newtons on a drum
    ],
)
def test_the_force_of_an_actuator_has_the_unit_of_what_it_acts_on(actuator, unit):
    sensor = "<actuatorfrc name='read' actuator='drive'/>"
    model = mujoco.MjModel.from_xml_string(lever(actuator, sensor, joint='name="hinge"'))
    assert reading_unit(model, 0) == unit
    if unit != UNKNOWN:  # of what, on a free joint?
        free = lever(actuator, sensor, joint='name="hinge" type="free"')
        assert reading_unit(mujoco.MjModel.from_xml_string(free), 0) == UNKNOWN


@pytest.mark.parametrize("name", ["bench", "joint", "finger"])
def test_every_live_parameter_has_a_unit(name):
    for parameter in Adjustable(load_model(name)).parameters().values():
        assert parameter.kind != "live" or parameter.unit != UNKNOWN


def test_a_column_in_another_unit_than_its_sensor_is_refused():
    right = joint_recording()
    columns = {**right.columns, "joint_m": right.columns["joint_rad"]}
    wrong = dataclasses.replace(
        right, columns=columns, measured={"joint_m": Measured("joint_angle")}
    )
    with refusing(RecordingError, "[rad]", "'joint_rad'"):
        Simulator([wrong])
    tension = dataclasses.replace(
        bench_recording(),
        columns={**bench_recording().columns, "input_tension_m": np.zeros(100)},
        measured={"input_tension_m": Measured("input_tension")},
    )
    with refusing(RecordingError, "[N]", "'input_tension_N'"):
        Simulator([tension])


def test_a_number_of_any_kind_is_a_value_and_nothing_else():
    simulate = Simulator([RECORDINGS[0]])
    kinds = (0.5, np.float64(0.5), np.float32(0.5), np.array(0.5))
    (first,), *others = simulate([{"environment.mass": kind} for kind in kinds])
    assert all(same(first, other) for (other,) in others)
    for name in ("sheath.friction", "environment.mass", "input_tension.lag"):
        with refusing(InvalidValueError, name):
            simulate([{name: "0.3"}])


def test_a_recording_that_there_is_not_is_refused_after_the_at_too():
    simulate = Simulator(RECORDINGS[:2])
    for name, fact in (("shrt", "did you mean 'short'"), ("", "''")):
        with refusing(UnknownNameError, "sheath.friction @ ", fact):
            simulate([{f"sheath.friction @ {name}": 0.1}])


def test_recordings_of_one_model_by_several_paths_are_simulated_together(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    text = model_path("bench").read_text("utf-8")
    (tmp_path / "bench.xml").write_text(text)
    paths = ("bench.xml", str(tmp_path / "bench.xml"))
    first, second = (bench_recording(0.1, model=path) for path in paths)
    (answer,) = Simulator([first, second])([{}])
    np.testing.assert_array_equal(answer[0]["input_tension_N"], answer[1]["input_tension_N"])
