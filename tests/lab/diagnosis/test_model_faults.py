"""Parts of a model that no fitted value mends: few guides, soft friction, soft flanks of play."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from experiments.one_capstan import PLAY, build, noisy, record
from tendon_mj import replay_recording
from tendon_mj.lab.diagnosis import (
    CATALOGUE,
    Problem,
    all_samples,
    diagnose,
    fit_with_sysid,
    sysid_is_there,
)
from tendon_mj.lab.diagnosis.data import with_more_guides
from tendon_mj.lab.diagnosis.model_faults import (
    too_few_guides,
    warn_of_guides,
    warn_of_servos,
    warn_of_soft_friction,
)
from tendon_mj.lab.recordings import Recording, Uncertain
from tendon_mj.lab.replay import Simulator
from tendon_mj.models import Bench, build_bench
from tests.lab.diagnosis.test_wrong_numbers import PENDULUM, measured
from tests.lab.diagnosis.toy import Toy, bench_recording, recording
from tests.lab.recorded import recorded

TENSION = "input_tension_N"
LOOP_NOISE = 0.02  # [N]
MANY = 64  # guides: as good as a smooth sheath
FRICTION = 0.3


def loop():
    time = np.arange(0.0, 1.5, 0.01)
    drive = 2.4e-3 * np.abs(np.sin(4.0 * time))
    return bench_recording("r", time, drive, LOOP_NOISE, [TENSION])


def simulated(guides):
    model = build_bench(Bench(friction=FRICTION, guides=guides)).compile()
    return Simulator([loop()], model, threads=1)


def problem(guides, simulator=simulated):
    smooth = simulated(MANY)([{}])[0][0][TENSION]
    data = loop()
    data = replace(data, columns={**data.columns, TENSION: smooth})
    return Problem((data,), simulator(guides), all_samples((data,)))


def error_left(told):
    return float(np.sqrt(np.mean(told.residuals([{}])[0] ** 2)))


def test_what_few_guides_leave_is_no_more_than_is_said():
    told = problem(6)
    (sheath,) = too_few_guides(told, {}, np.inf)
    assert sheath.guides == 6
    assert 1.0 < error_left(told) < sheath.error


def test_as_many_as_are_said_would_do():
    told = problem(6)
    (sheath,) = too_few_guides(told, {}, error_left(told))
    assert error_left(problem(sheath.enough)) < 1.5
    assert f"{sheath.enough} guides would do" in warn_of_guides([sheath])[0]


def test_what_more_guides_change_leaves_no_more_than_is_said(tmp_path):
    """And little from values nearby; what is simulated keeps the model's own guides."""
    named = tmp_path / "few.xml"
    named.write_text(build_bench(Bench(friction=FRICTION, guides=6)).to_xml())
    few = problem(6, lambda _: Simulator([replace(loop(), model=str(named))], threads=1))
    corrected, near = (with_more_guides(few, {"sheath.friction": s * FRICTION}) for s in (1, 0.99))
    assert corrected.simulate is few.simulate
    (share,) = corrected.lumping.values()
    span = float(np.ptp(few.recordings[0].columns[TENSION]))
    assert error_left(corrected) < share * span / LOOP_NOISE < 0.1 * error_left(few)
    assert error_left(near) < 0.05 * error_left(few)


@pytest.mark.parametrize("values", [{"sheath.friction": 0.0}, {"sheath.friction": 0.001}])
def test_without_friction_no_guide_is_too_few(values):
    assert too_few_guides(problem(6), values, np.inf) == []


def test_more_bend_needs_more_guides():
    (drawn,) = too_few_guides(problem(6), {}, np.inf)
    (more,) = too_few_guides(problem(6), {"sheath.extra_bend": 2.0}, np.inf)
    assert more.enough > drawn.enough


@pytest.mark.skipif(not sysid_is_there(), reason="mujoco.sysid lacks its extras")
@pytest.mark.parametrize("guides", [16, 48])  # with 48 the tendon rings in longer steps
def test_a_calibration_ends_no_worse_than_a_fit_by_sysid(guides):
    random = np.random.default_rng(0)
    uncertain = {"sheath.friction": Uncertain(0.15, 0.05, 0.4)}
    smooth = problem(MANY).recordings[0].columns[TENSION]
    train, held_out = (
        replace(
            loop(),
            name=name,
            uncertain=uncertain,
            columns={
                **loop().columns,
                TENSION: smooth + random.normal(0.0, LOOP_NOISE, smooth.size),
            },
        )
        for name in ("train", "held_out")
    )

    def lumped(recordings):
        return Simulator(recordings, build_bench(Bench(guides=guides)).compile(), threads=1)

    result = diagnose([train], [held_out], lumped, catalogue=[CATALOGUE["backlash"]])
    by_sysid = fit_with_sysid([train], [held_out], simulator=lumped)
    assert result.train.before < 1.01 * by_sysid.train_rms


STIFF = 'solreffriction="0.002 1" solimpfriction="0.9999 0.9999 0.001 0.5 2"'


def simulator(folder: Path, friction: str) -> Simulator:
    one = measured("motor", {}, folder)[0]
    model = folder / "other.xml"
    text = PENDULUM.format(actuator='<motor name="motor" joint="elbow" gear="2"/>')
    model.write_text(text.replace('solreffriction="0.002 1"', friction))
    return Simulator([replace(one, model=str(model))])


@pytest.mark.parametrize("friction", ["", 'solreffriction="0.002 1"'])
def test_soft_friction_is_warned_of_with_what_makes_it_stiff(friction: str, tmp_path: Path) -> None:
    soft = simulator(tmp_path, friction)
    (warning,) = warn_of_soft_friction(soft, {"elbow.frictionloss": 0.1})
    assert warning.startswith("Joint elbow: ")
    assert STIFF in warning  # twice the time step
    assert warn_of_soft_friction(simulator(tmp_path, STIFF), {"elbow.frictionloss": 0.1}) == []


def test_friction_that_is_not_there_is_not_warned_of(tmp_path: Path) -> None:
    soft = simulator(tmp_path, "")
    assert warn_of_soft_friction(soft, {"elbow.frictionloss": 0.0, "elbow.damping": 0.1}) == []
    assert warn_of_soft_friction(Toy([recording("r", 0, {})]), {"elbow.frictionloss": 0.1}) == []


@pytest.mark.parametrize(("way", "warned"), [("soft spool", True), ("prescribed", False)])
def test_a_play_that_is_found_on_a_soft_flank_is_warned_of(
    way: str, warned: bool, tmp_path: Path
) -> None:
    path = tmp_path / "wrist.xml"
    path.write_text(build(way).to_xml())
    time = np.arange(0.0, 3.0, 0.02)
    made = record(
        "loops", time, 40.0 * np.sin(3.0 * time), np.zeros((time.size, 3)), way, str(path)
    )
    play = {f"{cable}_sheath.backlash": PLAY for cable in ("agonist", "antagonist")}
    shown = replay_recording(made, parameters=play)
    columns = np.array([shown.columns[c] for c in made.measured]) * [[1.0], [1.0], [180.0 / np.pi]]
    readings = noisy(columns.T, np.random.default_rng(1))
    result = diagnose(
        [record("loops", time, 40.0 * np.sin(3.0 * time), readings, way, str(path))],
        catalogue=[CATALOGUE["backlash"]],
    )
    assert result.effects == ["backlash"]
    said = [w for w in result.warnings if "flank" in w]
    assert [w.startswith("Joint 'spool': ") for w in said] == [True] * warned


def test_servos_that_nothing_measured_are_named_until_a_range_is_given(tmp_path: Path) -> None:
    def warned(recording: Recording) -> list[str]:
        made = (recording,)
        return warn_of_servos(Problem(made, Simulator(made), all_samples(made)))

    assert warned(measured("servo", {}, tmp_path)[0]) == []  # its joint's angle is measured
    time = np.arange(0.0, 0.4, 0.01)
    drive = {"command_rad": ("command", np.sin(12.0 * time))}
    blind = recorded(time, drive, {"joint_rad": ("joint_angle", 1e-3)}, "joint")
    (warning,) = warned(blind)
    assert "(command)" in warning
    assert "'command.kp' a range" in warning
    assert warned(replace(blind, uncertain={"command.kp": Uncertain(4e3, 1e3, 8e3)})) == []


def test_few_guides_do_not_decide_a_verdict(tmp_path):
    """A replay is off by 2 noises; friction, and that nothing is missing, are right."""
    few, smooth = tmp_path / "few.xml", tmp_path / "smooth.xml"
    for path, guides in ((few, 9), (smooth, MANY)):
        path.write_text(build_bench(Bench(friction=0.15, bend=3.7, guides=guides)).to_xml())
    time, random = np.arange(0.0, 1.0, 0.01), np.random.default_rng(1)
    tensions, made = [TENSION, "output_tension_N"], []
    for k, share in enumerate((0.6, 1.0)):
        drive = 1.3e-3 * np.sin(8.0 * time) * (1.0 - share * np.sin(1.6 * time) ** 2)
        blank = bench_recording(f"r{k}", time, drive, LOOP_NOISE, tensions)
        rig = Simulator([replace(blank, model=str(smooth))], timestep=1e-4)
        read = rig([{"sheath.friction": 0.19}])[0][0]
        columns = {c: read[c] + random.normal(0.0, LOOP_NOISE, time.size) for c in tensions}
        uncertain = {"sheath.friction": Uncertain(0.15, 0.05, 0.4)}
        columns = {**blank.columns, **columns}
        made.append(replace(blank, model=str(few), uncertain=uncertain, columns=columns))
    result = diagnose(made[:1], made[1:], catalogue=[CATALOGUE["sensor_bias"]])
    assert result.verdict == "nothing missing"
    friction = result.calibrated["sheath.friction"]
    assert friction.low < 0.19 < friction.high
    assert result.evidence.extrapolated.before < 1.2
    assert "has only 9 guides may leave up to" in result.sentence
