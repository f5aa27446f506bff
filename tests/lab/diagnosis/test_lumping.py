"""Few guides in place of a smooth sheath: what they leave, and how many would do."""

from dataclasses import replace

import numpy as np
import pytest

from tendon_mj.lab.diagnosis import (
    CATALOGUE,
    Problem,
    all_samples,
    diagnose,
    fit_with_sysid,
    sysid_is_there,
)
from tendon_mj.lab.diagnosis.model_faults import too_few_guides, warn_of_guides
from tendon_mj.lab.recordings import Measured, Recording, Uncertain
from tendon_mj.lab.replay import Simulator
from tendon_mj.models import Bench, build_bench

TENSION, REEL = "input_tension_N", "input_displacement_m"
NOISE = 0.02  # [N]
MANY = 64  # guides: as good as a smooth sheath
FRICTION = 0.3


def recording():
    time = np.arange(0.0, 3.0, 0.01)
    drive = 2.4e-3 * np.abs(np.sin(2.0 * time))
    return Recording(
        source="made",
        name="r",
        model="bench",
        time=time,
        columns={REEL: drive, TENSION: np.zeros_like(time)},
        drive={REEL: "reel"},
        measured={TENSION: Measured("input_tension", noise=NOISE)},
    )


def simulated(guides):
    model = build_bench(Bench(friction=FRICTION, guides=guides)).compile()
    return Simulator([recording()], model, threads=1)


def problem(guides, simulator=simulated):
    smooth = simulated(MANY)([{}])[0][0][TENSION]
    data = recording()
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
            recording(),
            name=name,
            uncertain=uncertain,
            columns={
                **recording().columns,
                TENSION: smooth + random.normal(0.0, NOISE, smooth.size),
            },
        )
        for name in ("train", "held_out")
    )

    def lumped(recordings):
        return Simulator(recordings, build_bench(Bench(guides=guides)).compile(), threads=1)

    found = diagnose([train], [held_out], lumped, catalogue=[CATALOGUE["backlash"]])
    by_sysid = fit_with_sysid([train], [held_out], simulator=lumped)
    assert found.train.before < 1.01 * by_sysid.train_rms
