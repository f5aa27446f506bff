"""Each fault that a recording may have is warned of by its own name, and a sound one of nothing."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest

from experiments.one_capstan import DRUM, build, record
from tendon_mj import Measured, Recording, Uncertain, add_friction, replay_recording
from tendon_mj.errors import RecordingError
from tendon_mj.lab.data_check import check_recording, timing_warnings
from tendon_mj.lab.data_check.column import Column, columns_of
from tendon_mj.lab.data_check.columns import spike_warnings, turn
from tendon_mj.lab.data_check.jumps import Jump, is_sudden
from tendon_mj.models import Bench, build_bench
from tests.lab.recorded import recorded
from tests.refusals import refusing

NOISE = 0.05


@pytest.fixture(scope="module")
def pull(tmp_path_factory: pytest.TempPathFactory) -> Recording:
    """Two seconds of a coarse bench, as another friction makes them, with noise."""
    bench = build_bench(Bench(guides=6, timestep=1e-3))
    path = tmp_path_factory.mktemp("coarse") / "bench.xml"
    path.write_text(bench.to_xml() if bench.compile() else "", encoding="utf-8")
    time = np.arange(0.0, 2.0, 0.01)
    made = recorded(
        time,
        {"reel_m": ("reel", 1e-3 * np.sin(5.0 * time))},
        {"in_N": ("input_tension", NOISE), "out_N": ("output_tension", NOISE)},
        path,
        name="pull",
        uncertain={"sheath.friction": Uncertain(0.15, 0.05, 0.4)},
    )
    shown = replay_recording(made, parameters={"sheath.friction": 0.2})
    random = np.random.default_rng(3)
    noisy = {c: shown.columns[c] + random.normal(0.0, NOISE, time.size) for c in made.measured}
    return replace(made, columns={**made.columns, **noisy})


def changed(recording: Recording, **columns: object) -> Recording:
    return replace(recording, columns={**recording.columns, **columns})  # type: ignore[dict-item]


def said(recording: Recording, **given: object) -> dict[str, str]:
    """Identifier → sentence of the warnings; each names the recording and a way out."""
    found = check_recording(recording, **given).warnings  # type: ignore[arg-type]
    assert all(recording.name in warning.place and warning.way_out for warning in found)
    return {warning.identifier: warning.sentence for warning in found}


def test_a_sound_recording_is_warned_of_nothing(pull: Recording) -> None:
    checked = check_recording(pull)
    assert checked.warnings == ()
    assert checked.simulated is not None
    assert set(checked.simulated.columns) == {"reel_m", "in_N", "out_N"}


def test_a_sawtooth_over_all_of_a_converter_is_no_counter() -> None:
    time = 0.01 * np.arange(600)
    drive = 3e-6 * (np.mod(np.arange(600), 2**8) - 128.0)
    read = {"in_N": ("input_tension", NOISE), "out_N": ("output_tension", NOISE)}
    made = replay_recording(recorded(time, {"reel_m": ("reel", drive)}, read, name="saw"))
    assert "wraps" not in said(made)


@pytest.mark.parametrize(("friction", "warned"), [(2.0, False), (2.1, True), (15.0, True)])
def test_a_friction_that_no_sheath_has_is_named(
    pull: Recording, friction: float, warned: bool
) -> None:
    guess = {"sheath.friction": Uncertain(friction, 0.05, 20.0)}
    sentences = said(replace(pull, uncertain=guess))
    assert ("friction" in sentences) == warned
    assert not warned or f"friction = {friction:g}" in sentences["friction"]


def test_a_bend_in_degrees_is_named(pull: Recording) -> None:
    drawn = {"sheath.drawn_bend": 180.0}
    assert "a bend in degrees" in said(replace(pull, known=drawn))["friction"]


@pytest.mark.parametrize(("times", "warned"), [(1.0, False), (1.6, False), (2.0, True)])
def test_a_diameter_in_the_place_of_a_radius_is_named(times: float, warned: bool) -> None:
    """Of a drum that winds in a cable and turns a lever on a soft spring."""
    time = np.arange(0.0, 2.0, 0.01)
    drive = {"drum_rad": ("drum", 0.5 * np.sin(5.0 * time))}
    made = recorded(time, drive, {"lever_rad": ("lever", 1e-4)}, name="wound", model="wound")
    model = wound(0.01)
    shown = replay_recording(made, model)
    given = said(shown, model=wound(0.01 * times))
    assert ("diameter" in given) == warned


def wound(radius: float) -> mujoco.MjModel:
    """A lever that a cable pulls, which a servo winds on a drum of a radius."""
    spec = mujoco.MjSpec.from_string("""<mujoco><option timestep="0.001"/><worldbody>
      <body name="drum" pos="-.2 0 0"><joint name="drum" axis="0 1 0" armature=".01" damping=".1"/>
        <geom size=".005" contype="0" conaffinity="0"/></body>
      <site name="a" pos="-.1 0 .02"/><site name="b" pos="0 0 .05"/>
      <body pos=".1 0 0"><joint name="lever" axis="0 1 0" stiffness="1" damping=".05"/>
        <geom size=".02" contype="0" conaffinity="0"/><site name="c" pos="0 0 .03"/></body>
      </worldbody><tendon><spatial name="t"><site site="a"/><site site="b"/><site site="c"/>
      </spatial></tendon>
      <actuator><position name="drum" joint="drum" kp="100" kv="2"/></actuator>
      <sensor><jointpos name="lever" joint="lever"/></sensor></mujoco>""")
    add_friction(
        spec,
        "t",
        friction=0.05,
        axial_stiffness=2e3,
        pretension=20.0,
        reel_joint="drum",
        reel_radius=radius,
    )
    return spec.compile()


@pytest.mark.parametrize("size", [2, 3, 7, 20, 45])
def test_a_part_of_a_sound_recording_is_warned_of_nothing(pull: Recording, size: int) -> None:
    columns = {c: series[-size:] for c, series in pull.columns.items()}
    part = replace(pull, time=pull.time[:size], columns=columns)
    assert set(said(part)) <= {"start"}  # it begins in motion


@pytest.mark.parametrize("wait", [20, 40])
def test_a_tension_that_follows_a_turn_late_is_no_tare_and_a_step_of_a_zero_is(wait: int) -> None:
    time = 0.01 * np.arange(800)
    read = {"in_N": ("input_tension", NOISE)}
    drive = {"reel_m": ("reel", 3e-3 * np.sin(0.4 * time))}
    shown = replay_recording(recorded(time, drive, read, name="turn"))
    model = shown.columns["in_N"] + np.random.default_rng(3).normal(0.0, NOISE, time.size)
    after = time > time[np.argmax(shown.columns["in_N"])]
    late = model - 8.0 * after  # more friction than the model's
    crossed = np.flatnonzero(after)[:wait]
    late[crossed] = model[crossed[0] - 1]
    assert "zero_step" not in said(changed(shown, in_N=late))
    assert "zero_step" in said(changed(shown, in_N=model - 8.0 * (time > 5.0)))


@pytest.mark.parametrize(("steps", "is_tare"), [(0.0, False), (0.777, True), (-0.777, True)])
def test_a_corner_of_a_tension_is_no_tare(steps: float, is_tare: bool) -> None:
    read = np.array([16.504, 16.107, 15.707, 15.461, 15.248, 15.448, 15.369, 15.308, 15.272])
    read[5:] += steps
    assert is_sudden(read, Jump(5, steps or 0.777), 0.05) == is_tare


def test_a_tension_that_falls_within_some_samples_behind_a_play_is_no_tare() -> None:
    time = 0.02 * np.arange(400)
    read = {"in_N": ("input_tension", NOISE)}
    drive = {"reel_m": ("reel", 3e-3 * np.sin(0.4 * time))}
    shown = replay_recording(recorded(time, drive, read, name="turn"))
    turn = time[np.argmax(shown.columns["in_N"])]
    noise = np.random.default_rng(3).normal(0.0, NOISE, time.size)
    for begin in (0.400, 0.408, 0.416):  # behind the turn, between two samples
        since = np.maximum(0.0, time - turn - begin)
        late = shown.columns["in_N"] - 20.0 * (1.0 - np.exp(-since / 0.04)) + noise
        assert "zero_step" not in said(changed(shown, in_N=late))


def test_times_in_ms_are_warned_of_and_not_simulated(pull: Recording) -> None:
    late = replace(pull, time=1000.0 * pull.time)
    checked = check_recording(late)
    assert checked.simulated is None
    assert [w.identifier for w in checked.warnings] == ["times_in_ms"]
    assert "200 samples 10 s apart, 1990 s in all" in checked.warnings[0].sentence
    assert "name the column 'time_ms'" in checked.warnings[0].way_out


def test_the_longest_gap_is_told_with_its_row_also_of_slow_samples(pull: Recording) -> None:
    time = np.array(pull.time)
    time[100:] += 0.2
    time[150:] += 0.3
    (warning,) = timing_warnings(replace(pull, time=time))
    assert warning.identifier == "gap"
    assert "2 gaps, the longest 0.31 s" in warning.value
    assert "(row 151)" in warning.value
    assert timing_warnings(pull) == []
    found = timing_warnings(replace(pull, time=500.0 * time))
    assert [warning.identifier for warning in found] == ["times_in_ms", "gap"]


def test_a_settle_of_any_length_that_cannot_be_simulated_is_refused(pull: Recording) -> None:
    assert "settle = 30000 s" in timing_warnings(replace(pull, settle=3e4))[0].value
    with refusing(RecordingError, "in the settle of 1e+12 s before"):
        check_recording(replace(pull, settle=1e12))


def late(recording: Recording, intervals: float) -> Recording:
    """Times of which one interval is so many times as long."""
    steps = np.full(recording.time.size - 1, 0.01)
    steps[100] *= intervals
    return replace(recording, time=np.append(0.0, np.cumsum(steps)))


def samples(count: int, interval: float) -> Recording:
    time = interval * np.arange(count)
    drive = {"reel_m": ("reel", 1e-3 * np.sin(time))}
    return recorded(time, drive, {"in_N": ("input_tension", NOISE)}, name="made")


@pytest.mark.parametrize(
    ("identifier", "made", "sound", "faulty"),
    [
        ("times_in_ms", lambda pull, interval: samples(200, interval), 0.45, 0.55),
        ("times_in_ms", lambda pull, count: samples(count, 1.0), 90, 110),
        ("times_too_short", lambda pull, interval: samples(200, interval), 6e-5, 4e-5),
        ("times_too_short", lambda pull, count: samples(count, 4e-5), 13000, 12000),
        ("gap", late, 4.5, 5.5),
        ("long_settle", lambda pull, settle: replace(pull, settle=settle), 50.0, 70.0),
    ],
)
def test_times_are_warned_of_from_a_limit_on(
    pull: Recording,
    identifier: str,
    made: Callable[[Recording, float], Recording],
    sound: float,
    faulty: float,
) -> None:
    for value, warned in ((sound, False), (faulty, True)):
        found = {warning.identifier for warning in timing_warnings(made(pull, value))}
        assert (identifier in found) == warned


@pytest.mark.parametrize(("step", "blocks"), [(0.035, False), (0.055, True)])
def test_a_gap_blocks_where_a_drive_may_have_left_its_line_by_2_percent(
    step: float, blocks: bool
) -> None:
    """A drive of 2 mm goes straight on behind a gap of ten intervals, a step farther."""
    time = np.delete(0.01 * np.arange(201), np.arange(101, 110))
    drive = {"reel_m": ("reel", 1e-3 * (time + step * (time > 1.05)))}
    made = recorded(time, drive, {"in_N": ("input_tension", NOISE)}, name="gap")
    (warning,) = timing_warnings(made)
    assert (warning.identifier, warning.blocks) == ("gap", blocks)


def with_output(change: Callable[[np.ndarray], np.ndarray]) -> Callable[[Recording], Recording]:
    return lambda pull: changed(pull, out_N=change(pull.columns["out_N"].copy()))


def at(rows: slice | int, value: float | None = None) -> Callable[[np.ndarray], np.ndarray]:
    """A series that has one value in some rows; by default that of the first of them."""

    def change(series: np.ndarray) -> np.ndarray:
        series[rows] = series[rows][0] if value is None else value
        return series

    return change


SCALED = {"output_tension.offset": 20.0}
ROWS = np.arange(200) + 2  # of the file
FAULTS: dict[str, tuple[Callable[[Recording], Recording], str, tuple[str, ...]]] = {
    **{
        f"output times {factor:g}": (with_output(lambda y, f=factor: f * y), "unit", ("'out_N'", m))
        for factor, m in (
            (1e3, "times as much, as thousandths"),
            (1e-3, "times as little, as thousands"),
            (57.3, "times as much, as degrees"),
            (1.0 / 57.3, "times as little, as radians"),
        )
    },
    **{
        f"drive times {factor:g}": (
            lambda p, f=factor: changed(p, reel_m=f * p.columns["reel_m"]),
            "unit",
            ("[drive] 'reel_m'", moves, '"reel.command_scale" in [known]'),
        )
        for factor, moves in ((1e-3, "moves less"), (57.3, "moves more"))
    },
    "kilograms-force": (
        with_output(lambda y: y / 9.81),
        "unit",
        ("kilograms-force named newtons",),
    ),
    "a reversed sensor": (
        with_output(lambda y: 2.0 * np.mean(y) - y),
        "sign",
        ('"output_tension.scale" = -1', "correlation -"),
    ),
    "another start": (with_output(lambda y: y + 25.0), "start", ("at 45", "the model at 20 N")),
    "another start of a pretension that is fitted": (
        lambda p: replace(
            with_output(lambda y: y + 25.0)(p),
            uncertain={"*.pretension": Uncertain(20.0, 10.0, 50.0)},
        ),
        "start",
        ("which a fit tells",),
    ),
    "a counter with a zero of its own": (
        lambda p: replace(
            changed(p, reel_m=p.columns["reel_m"] + 2e-3), in_file={"reel_m": "reel_mm"}
        ),
        "start",
        ("'reel_mm' begins at 2 mm", "by 2; where it has no entry there, write reel_mm = { column"),
    ),
    "a counter that begins again": (
        with_output(lambda y: np.mod(np.round(y / 0.01), 2**10) * 0.01),
        "wraps",
        ("2^10 = 1024 of its steps of 10 mN", "by period in [columns]", "1024 of such steps"),
    ),
    "a drive that begins again beside a load cell with the other sign": (
        lambda p: changed(
            p,
            reel_m=np.mod(np.round(p.columns["reel_m"] / 1e-5), 2**8) * 1e-5,
            out_N=-p.columns["out_N"],
        ),
        "wraps",
        ("'reel_m'", "256 of such steps, or 2.56 mm"),
    ),
    "a spike": (with_output(at(slice(100, 101), 4e3)), "spike", ("4 kN in row 102, between",)),
    "a number in the place of missed readings": (
        with_output(at(slice(60, 69), -999.0)),
        "no_reading",
        ("reads -999 N in 9 samples, the first in row 62", "leave their rows out"),
    ),
    "hardly moving": (with_output(lambda y: 20.0 + 1e-5 * y), "nothing_moves", ("not connected",)),
    "frozen": (with_output(at(slice(60, 110))), "frozen", ("from row 62 to 111",)),
    "a model that stands still": (
        lambda p: replace(p, known=SCALED | {"output_tension.scale": 0.0}),
        "nothing_moves",
        ("stands still at 20 N",),
    ),
    **{
        f"a model that moves by 1/{factor:g}": (
            lambda p, f=factor: replace(p, known=SCALED | {"output_tension.scale": 1.0 / f}),
            "nothing_moves",
            ("of the model hardly moves", "[drive]"),
        )
        for factor in (1e4, 1e5)
    },
    "a drive scaled twice": (
        lambda p: replace(p, known={"reel.command_scale": 0.01}),
        "unit",
        ("multiplied by reel.command_scale = 0.01",),
    ),
    "a slack cable": (
        lambda p: replace(
            changed(p, reel_m=p.columns["reel_m"] - 0.01), known={"sheath.pretension": 0.0}
        ),
        "slack",
        ("the sign of the radius",),
    ),
    "no drive": (lambda p: replace(p, drive={}), "nothing_moves", ("no column is in [drive]",)),
    "a drive that stands still": (
        lambda p: changed(p, reel_m=np.full(p.time.size, 1e-3)),
        "nothing_moves",
        ("'reel_m'", "stands still"),
    ),
    "an output that stands still": (
        with_output(at(slice(None), 20.0)),
        "nothing_moves",
        ("'out_N'", "reads 20 N from the first sample to the last"),
    ),
    **{
        f"a glitch in row {row}": (
            with_output(lambda y, k=row: np.where(k == ROWS, y + 3.0 * np.ptp(y), y)),
            "spike",
            (f"in row {row}, between",),
        )
        for row in (2, 201)
    },
    "no fault, but coarse steps": (
        with_output(lambda y: np.round(y / np.ptp(y), 2) * np.ptp(y)),
        "",
        (),
    ),
}


def scaled(series: np.ndarray, times: float) -> np.ndarray:
    return np.mean(series) + times * (series - np.mean(series))


@pytest.mark.parametrize(("times", "drive"), [(4.0, False), (5.5, True)])
def test_the_drive_is_meant_where_every_reading_is_off_by_5_or_more(
    pull: Recording, times: float, drive: bool
) -> None:
    more = {c: scaled(pull.columns[c], times) for c in pull.measured}
    warnings = check_recording(changed(pull, **more)).warnings
    assert any(w.identifier == "unit" and "[drive]" in w.place for w in warnings) == drive


@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_is_told_alone_with_its_place_and_value(pull: Recording, fault: str) -> None:
    change, identifier, facts = FAULTS[fault]
    found = said(change(pull))
    assert list(found) == ([identifier] if identifier else [])
    assert all(fact in found[identifier] for fact in facts)


@pytest.mark.parametrize(("motion", "told"), [(12.0, True), (4.0, False)])
def test_kilograms_force_are_asked_after_where_the_start_and_the_motion_are_so_much_smaller(
    pull: Recording, motion: float, told: bool
) -> None:
    """Whatever the friction; a start alone that is so small is another pretension."""
    out = pull.columns["out_N"]
    found = said(changed(pull, out_N=out[0] / 9.81 + (out - out[0]) / motion))["start"]
    assert ("kilograms-force" in found) == told
    assert "the pretension may be another" in found


@pytest.mark.parametrize(("rest", "first"), [(0, True), (50, False)])
def test_motion_in_the_first_rows_is_the_first_cause_of_another_start(
    pull: Recording, rest: int, first: bool
) -> None:
    """The drive's zero is asked after, too: both are away from the model's reference pose."""
    reel = 3e-3 + 1e-3 * np.sin(5.0 * 0.01 * np.maximum(np.arange(200) - rest, 0))
    found = said(changed(pull, reel_m=reel, out_N=pull.columns["out_N"] + 60.0))["start"]
    moved, zero = found.index("friction remembers"), found.index("the drive 'reel_m' begins at")
    assert (moved < zero) == first == ("moves from the first row on" in found)


@pytest.mark.parametrize("fitted", [(), ("rest_in",)])
def test_a_gear_that_is_stated_without_its_rests_is_told(
    pull: Recording, fitted: tuple[str, ...]
) -> None:
    rests = {f"input_tension.{name}": Uncertain(0.0, -1.0, 1.0) for name in fitted}
    known = {**pull.known, "input_tension.efficiency": 0.8}
    found = said(replace(pull, known=known, uncertain={**pull.uncertain, **rests}))
    assert ("gear" in found) == (not fitted)


SLOW = """<mujoco>
  <worldbody><body>
    <joint name="hinge" axis="0 1 0" damping="0.5"/>
    <geom type="capsule" size="0.01" fromto="0 0 0 0.1 0 0" mass="0.5"/>
  </body></worldbody>
  <actuator><motor name="motor" joint="hinge"/></actuator>
  <sensor><jointpos name="angle" joint="hinge"/></sensor>
</mujoco>"""


@pytest.mark.parametrize(("settle", "told"), [(2.0, ["short_settle"]), (16.0, [])])
def test_a_model_that_needs_longer_to_settle_is_told_how_long(
    settle: float, told: list[str], tmp_path: Path
) -> None:
    (tmp_path / "slow.xml").write_text(SLOW)
    time = np.arange(0.0, 4.0, 0.02)
    drive = {"motor_Nm": ("motor", 0.2 * np.sin(3.0 * time))}
    blank = recorded(time, drive, {"angle_rad": ("angle", 1e-3)}, tmp_path / "slow.xml")
    rested = replay_recording(blank, settle=30.0)
    found = said(replace(blank, columns=rested.columns, settle=settle))
    assert list(found) == told
    assert all("write settle = 8" in sentence for sentence in found.values())


def test_a_drive_that_makes_the_model_fail_is_told(pull: Recording) -> None:
    found = said(changed(pull, reel_m=1e9 * pull.columns["reel_m"]))
    assert "unstable" in found or "unit" in found


def test_a_sensor_that_the_model_lacks_is_refused(pull: Recording) -> None:
    with refusing(RecordingError, "did you mean 'output_tension'"):
        check_recording(replace(pull, measured={"out_N": Measured("outputtension")}))


@pytest.mark.parametrize("size", [1, 4])
def test_readings_that_drop_to_one_value_are_told_with_their_rows(
    pull: Recording, size: int
) -> None:
    out = pull.columns["out_N"].copy()
    low = float(np.median(out)) - 0.3 * np.ptp(out)  # within the range, as of a bus that repeats it
    rows = [k for k in range(20, 180, 10) if out[k] > np.median(out)]
    for row in rows:
        out[row : row + size] = low
    found = said(changed(pull, out_N=out))
    assert set(found) == {"spike"}
    assert f"the largest of {size * len(rows)}, the first in row {rows[0] + 2}" in found["spike"]


def test_a_step_of_the_drive_is_no_spike(pull: Recording) -> None:
    held = np.full(pull.time.size, 1e-3)
    held[[0, -1]] = 0.0
    for reel in (held, np.where(np.sin(5.0 * pull.time) > 0.0, 1e-3, -1e-3)):
        assert "spike" not in said(changed(pull, reel_m=reel))


# --- actuators

MOTOR = """<mujoco><extension><plugin plugin="tendon_mj.sheath">
<instance name="sheath"><config key="tendon" value="cable"/><config key="friction" value="0.1"/>
<config key="axial_stiffness" value="2000"/><config key="pretension" value="20"/>
<config key="reel_joint" value="spool"/><config key="reel_radius" value="0.01"/></instance>
<instance name="pull"><config key="sensor" value="input_tension"/></instance>
</plugin></extension>
<worldbody><site name="a"/><site name="b" pos="0.1 0 0"/><site name="c" pos="0.1 0.1 0"/>
<body pos="0 0 0.1"><joint name="spool" armature="0.01" damping="1"/><geom size="0.01"/></body>
<body pos="0.1 0.2 0"><joint type="slide" name="load" axis="0 1 0" stiffness="4000" damping="100"
 springref="0.005"/><geom size="0.05" contype="0"/><site name="d"/></body></worldbody>
<option gravity="0 0 0" timestep="0.001"/>
<tendon><spatial name="cable"><site site="a"/><site site="b"/><site site="c"/><site site="d"/>
</spatial></tendon>
<actuator><position name="motor" joint="spool" kp="50" {limits}/></actuator>
<sensor><plugin name="pull" objtype="tendon" objname="cable" instance="pull"/>
<jointpos name="spool" joint="spool"/></sensor></mujoco>"""


def driven(limits: str, rest: float = 0.0, settle: float = 0.5) -> dict[str, str]:
    model = mujoco.MjModel.from_xml_string(MOTOR.format(limits=limits))
    time = np.arange(0.0, 1.0, 0.01)
    angle = rest + 0.3 * np.sin(9.0 * time)
    made = recorded(
        time,
        {"motor_rad": ("motor", angle)},
        {"spool_rad": ("spool", None, 0.9 * angle)},
        name="pull",
        settle=settle,
    )
    return said(made, model=model)


def test_a_drive_at_the_ends_of_its_range_is_told() -> None:
    assert "saturated" not in driven('ctrlrange="-1 1" ctrllimited="true"')
    found = driven('ctrlrange="-0.2 0.2" ctrllimited="true"')
    assert "control range of actuator 'motor', -0.2 to 0.2" in found["saturated"]
    assert "the column goes from -0.2" in found["saturated"]


def test_a_motor_that_lets_go_before_it_begins_is_told() -> None:
    """Its servo bears T_0 r = 0.2 N m at rest with a command of 0.2/kp, and not with 0."""
    assert "lets_go" not in driven("")
    assert "lets_go" not in driven("", rest=0.2 / 50, settle=0.0)
    assert "write settle = 0.0" in driven("", rest=0.2 / 50)["lets_go"]
    assert "lets_go" not in driven("", rest=0.4 * 0.2 / 50)  # bears more than half of it
    assert "lets_go" in driven("", rest=0.6 * 0.2 / 50)


def test_a_motor_that_cannot_bear_the_pretension_is_told() -> None:
    """T_0 r = 20 N × 10 mm = 0.2 N m, less half the strain."""
    assert "weak_motor" not in driven('forcerange="-0.25 0.25" forcelimited="true"')
    found = driven('forcerange="-0.15 0.15" forcelimited="true"')
    assert "joint 'spool'" in found["weak_motor"]
    assert "pull it with 0.199 N m" in found["weak_motor"]
    assert "hold 0.15 N m" in found["weak_motor"]


PULLED = """<mujoco><extension><plugin plugin="tendon_mj.sheath">
<instance name="sheath"><config key="tendon" value="cable"/><config key="friction" value="0.1"/>
</instance><instance name="pull"><config key="sensor" value="input_tension"/></instance>
</plugin></extension><option gravity="0 0 0"/>
<worldbody><site name="a"/><site name="b" pos="0.1 0 0"/><body pos="0.1 0.2 0"><joint type="slide"
 axis="0 1 0" stiffness="4000" damping="100"/><geom size="0.05" contype="0"/><site name="d"/></body>
</worldbody><tendon><spatial name="cable"><site site="a"/><site site="b"/><site site="d"/></spatial>
</tendon><actuator><muscle name="muscle" tendon="cable" force="30" lengthrange="0.2 0.4"/>
</actuator><sensor><plugin name="pull" objtype="tendon" objname="cable" instance="pull"/></sensor>
</mujoco>"""


@pytest.mark.parametrize(("most", "weak"), [(25.0, False), (60.0, True)])
def test_a_tension_beyond_what_a_muscle_can_pull_is_told(most: float, weak: bool) -> None:
    model = mujoco.MjModel.from_xml_string(PULLED)
    time = np.arange(0.0, 1.0, 0.01)
    activation = 0.5 + 0.4 * np.sin(9.0 * time)
    made = recorded(
        time,
        {"activation_N": ("muscle", activation)},
        {"cable_N": ("pull", None, most * activation / 0.9)},
        name="pull",
    )
    found = said(made, model=model)
    assert ("weak_motor" in found) == weak
    if weak:
        assert "the actuators of tendon 'cable' pull with 30 N at most" in found["weak_motor"]


def test_an_angle_that_jumps_by_a_turn_is_told_with_its_row_and_nothing_else_is() -> None:
    time = np.arange(0.0, 2.0, 0.01)
    angle = 3.0 * np.sin(3.0 * time)
    wrapped = np.mod(angle + np.pi, 2.0 * np.pi) - np.pi
    lost = np.where(time > 1.2, angle + 2.0 * np.pi, angle)
    bare = recorded(
        time,
        {"command_rad": ("command", 0.5 * angle)},
        {"joint_rad": ("joint_angle", 0.01, 1.2 * angle)},
        "joint",
    )
    assert turn(Column(bare, "joint_rad")) is None
    for series in (lost, np.mod(1.2 * angle, 2.0 * np.pi), wrapped * 1.0):
        jumps = int((np.abs(np.diff(series)) > 5.0).sum())
        jumping = changed(bare, joint_rad=series)
        found = turn(Column(jumping, "joint_rad"))
        assert (found is not None) == (jumps > 0)
        if found:
            row = int(np.argmax(np.abs(np.diff(series)) > 5.0)) + 3
            assert f"in row {row}" in found.value
            assert not list(spike_warnings(columns_of(jumping)))


def test_rests_are_warned_of_only_where_they_are_too_close(pull: Recording) -> None:
    reel = np.resize(np.linspace(0.0, 1.2e-3, 7), 100)
    zeros = np.zeros(reel.size)
    made = replace(
        pull,
        time=10.0 * np.arange(reel.size),
        columns={"reel_m": reel, "in_N": zeros, "out_N": zeros},
        settling_time=0.5,
    )
    shown = replay_recording(made, parameters={"sheath.friction": 0.2})
    let_off = replace(made, columns=shown.columns)  # from the last point of each stair at once
    assert said(let_off) == {}
    read = shown.columns["in_N"].copy()
    top = float(np.percentile(read, 60.0))
    assert (
        "[measured] 'in_N': ends at"
        in said(changed(let_off, in_N=np.minimum(read, top)))["range_end"]
    )
    read[40:46] = read[40]
    (hung,) = check_recording(changed(let_off, in_N=read)).warnings
    assert hung.identifier == "frozen"
    assert "from row 42 to 47" in hung.value
    moving = replace(let_off, settling_time=None)
    assert {warning.identifier for warning in timing_warnings(moving)} == {"times_in_ms"}
    (warning,) = timing_warnings(replace(let_off, settling_time=15.0))
    assert warning.identifier == "rests_too_close"


def wrist(way: str, model: mujoco.MjModel) -> Recording:
    """A second of the rig with one capstan and two cables, as its model makes it."""
    time = np.arange(0.0, 1.0, 0.02)
    made = record("loops", time, 40.0 * np.sin(6.0 * time), np.zeros((time.size, 3)), way, "wrist")
    shown = replay_recording(made, model)
    return changed(made, **{c: shown.columns[c] for c in made.measured})


@pytest.mark.parametrize("measured", [False, True])
@pytest.mark.parametrize("way", ["reel", "spool", "prescribed"])
def test_degrees_named_radians_are_told_of_the_drive_and_of_what_was_measured(
    way: str, measured: bool
) -> None:
    model = build(way).compile()
    recording = wrist(way, model)
    assert check_recording(recording, model).warnings == ()
    columns = ["motor_rad"] + ["wrist_rad"] * measured
    degrees = {c: np.degrees(recording.columns[c]) for c in columns}
    found = check_recording(changed(recording, **degrees), model).warnings
    assert [warning.identifier for warning in found] == ["unit"] * len(columns)
    for warning, column in zip(found, columns, strict=True):
        assert repr(column) in warning.place
        assert repr(column.replace("rad", "deg")) in warning.way_out


def test_a_drive_in_the_place_of_what_it_moves_is_told() -> None:
    model = build("reel").compile()
    recording = wrist("reel", model)
    motor, wrist_angle = recording.columns["motor_rad"], recording.columns["wrist_rad"]
    exchanged = changed(recording, motor_rad=wrist_angle, wrist_rad=motor)
    (warning,) = check_recording(exchanged, model).warnings
    assert warning.identifier == "exchanged"
    assert warning.blocks
    assert "'wrist_rad'" in warning.value


def test_radians_of_many_turns_are_not_taken_for_degrees() -> None:
    model = build("reel").compile()
    recording = wrist("reel", model)
    turns = changed(recording, motor_rad=40.0 * recording.columns["motor_rad"])
    known = {
        f"{c}_reel.command_scale": s * DRUM / 40.0 for c, s in (("agonist", 1), ("antagonist", -1))
    }
    assert check_recording(replace(turns, known={**turns.known, **known}), model).warnings == ()


def test_a_flank_that_gives_way_is_told_with_an_armature_and_a_step_that_do() -> None:
    spec = build("soft spool")
    recording = wrist("soft spool", spec.compile())
    assert check_recording(recording, spec.compile()).warnings == (), (
        "without play nothing gives way"
    )
    model = spec.compile()
    inertia = float(model.dof_M0[model.joint("spool").dofadr[0]])
    pull = float(recording.columns["agonist_N"].max())
    flank = 4.0 * pull * (DRUM * model.opt.timestep) ** 2 / inertia

    def with_play(play: float) -> Recording:
        known = {f"{cable}_sheath.backlash": play for cable in ("agonist", "antagonist")}
        measured = {c: replace(m, noise=None) for c, m in recording.measured.items()}
        return replace(recording, known={**recording.known, **known}, measured=measured)

    assert "soft_flank" not in said(with_play(flank / 0.025), model=model)
    given = with_play(flank / 0.035)
    (warning,) = [w for w in check_recording(given, model).warnings if w.identifier == "soft_flank"]
    assert "'spool'" in warning.place
    assert f"{1e6 * flank:.2g} µm at {pull:.3g} N" in warning.value
    enough = float(re.search(r"armature of ([\d.e-]+)", warning.way_out)[1])
    step = 1e-6 * float(re.search(r"steps of ([\d.]+) µs", warning.way_out)[1])
    for armature, timestep in ((1.05 * enough, 1e-3), (inertia, 0.95 * step)):
        spec.joint("spool").armature = armature
        spec.option.timestep = timestep
        found = check_recording(given, spec.compile()).warnings
        assert "soft_flank" not in {w.identifier for w in found}


def test_a_play_that_is_only_possible_is_told_too_and_a_prescribed_joint_has_no_flank() -> None:
    possible = {"agonist_sheath.backlash": Uncertain(0.0, 0.0, 1e-3)}
    for way, told in (("soft spool", {"soft_flank"}), ("prescribed", set()), ("reel", set())):
        model = build(way).compile()
        recording = wrist(way, model)
        uncertain = replace(recording, uncertain={**recording.uncertain, **possible})
        assert {w.identifier for w in check_recording(uncertain, model).warnings} == told


@pytest.mark.parametrize("scale", [1.0, 5.0])
def test_a_prescribed_joint_that_is_measured_otherwise_is_told(scale: float) -> None:
    model = build("prescribed").compile()
    recording = wrist("prescribed", model)
    spec = build("prescribed")
    spec.add_sensor(
        name="own",
        type=mujoco.mjtSensor.mjSENS_JOINTPOS,
        objname=recording.driven[0][1],
        objtype=mujoco.mjtObj.mjOBJ_JOINT,
    )
    prescribed = recording.columns[next(iter(recording.drive))]
    random = np.random.default_rng(1).normal(0.0, 1e-3, prescribed.size)
    both = replace(
        recording,
        columns={**recording.columns, "own_rad": scale * prescribed + random},
        measured={**recording.measured, "own_rad": Measured("own")},
    )
    found = said(both, model=spec.compile())
    assert set(found) == ({"prescribed"} if scale > 1.0 else set())
