"""The benchmarked models are what they stand for; the study's figures and files."""

import functools
import itertools
import json
import math

import mujoco
import numpy as np
import pytest

from experiments.benchmarks import __main__ as command
from experiments.benchmarks.callback import (
    NumpySheath,
    as_passive_callback,
    bare_bench,
    disagreement,
)
from experiments.benchmarks.frictionloss import (
    compare_frictionloss,
    deviation,
    motor_bench,
    output_tension,
    slow_tension,
)
from experiments.benchmarks.scaling import (
    FAST,
    SLOW,
    cost_parts,
    exponent,
    guide_runs,
    parts_of,
    several_benches,
    with_instances,
)
from experiments.benchmarks.study import CostSeries, run_benchmark, scaling_figure
from experiments.benchmarks.threads import thread_speedups
from experiments.command import run_experiment
from tendon_mj import theory, view_sheath
from tendon_mj.errors import EngineError, InvalidValueError
from tendon_mj.models import Bench, build_bench
from tendon_mj.plugin import sheaths
from tests.refusals import refusing

WAVE = 1e-3 * np.sin(np.linspace(0.0, 4.0 * np.pi, 800))
BENCH = Bench()
PULLED = slow_tension(BENCH, 2000)
FORCE = 5.0


def test_the_exponent_of_a_power_is_its_power():
    counts = (1, 3, 10, 40)
    assert exponent(counts, [2e-6 * n**1.5 for n in counts]) == pytest.approx(1.5)
    assert np.isnan(exponent(counts, [1.0, 0.0, 1.0, 1.0]))


@pytest.mark.parametrize(("guides", "frequency"), [(16, SLOW), (16, FAST), (128, FAST)])
def test_every_guide_slides_both_ways(guides, frequency):
    run, reference = guide_runs(Bench(), guides, frequency)
    assert reference.model.nplugin == 0
    view, seen = view_sheath(run.model, run.data, "tendon"), []
    for control in run.controls:
        run.data.ctrl[:] = control
        mujoco.mj_step(run.model, run.data)
        seen.append(view.slip)
    assert (np.max(seen, axis=0) == 1.0).all()
    assert (np.min(seen, axis=0) == -1.0).all()
    assert view.unsolved == 0


def test_each_of_several_benches_moves_as_one_alone_or_with_instances_that_have_nothing_to_do():
    idle = {"tendon": "tendon", "sensor": "unsolved"}
    specs = [
        build_bench(Bench()),
        several_benches(lambda: build_bench(Bench()), 3),
        with_instances(build_bench(Bench()), "tendon_mj.sheath", idle, 5),
    ]
    models, results = [spec.compile() for spec in specs], []
    assert len(sheaths(models[1])) == 3
    for model in models:
        data = mujoco.MjData(model)
        for control in 1e-3 * np.sin(np.linspace(0.0, 6.0, 300)):
            data.ctrl[:] = control
            mujoco.mj_step(model, data)
        results.append(data.qpos.reshape(-1, 2).copy())
    np.testing.assert_allclose(results[1], np.tile(results[0], (3, 1)), rtol=1e-9)
    np.testing.assert_array_equal(results[0], results[2])


def test_the_parts_add_up():
    assert cost_parts(Bench(guides=3), rounds=1).empty_plugin is not None
    times = {"plain": 2.0, "plain one": 1.8, "idle": 13.0, "one": 2.3, "rest": 3.0, "sliding": 3.2}
    parts = parts_of({k: np.full(3, t) for k, t in {**times, "sensors": 3.6, "empty": 6.0}.items()})
    assert parts.sensors.median == pytest.approx(0.4)
    steps = ("empty_plugin", "idle_instance", "first_guide", "more_guides", "sliding")
    total = sum(getattr(parts, name).median for name in steps)
    assert total == pytest.approx(parts.total.median, rel=1e-9)


def test_the_scaling_shows_medians_in_microseconds_and_leaves_out_what_noise_exceeds():
    counts, medians = (4, 8, 16), np.array([-1e-7, 2e-6, 4e-6])
    added = np.stack([0.9 * medians, medians, 1.1 * medians], axis=-1)
    figure = scaling_figure(
        [CostSeries("slow", counts, added, 1.0)], CostSeries("benches", counts, added, 1.0)
    )
    line = figure.axes[0].get_lines()[0]
    np.testing.assert_allclose(line.get_ydata(), [np.nan, 2.0, 4.0])
    assert "added to a step [µs]" in figure.axes[0].get_ylabel()
    assert all("[–]" in axes.get_xlabel() for axes in figure.axes)


def test_the_study_writes_its_figures_and_numbers(tmp_path, monkeypatch, capsys):
    quick = functools.partial(run_benchmark, guides=(4, 16, 32), sheaths=(1, 2))
    monkeypatch.setattr(command, "run_benchmark", quick)
    arguments = ["--out", str(tmp_path), "--rounds", "1"]
    assert run_experiment(command.benchmarks, "benchmarks", arguments) == 0
    result = json.loads((tmp_path / "result.json").read_text("utf-8"))
    exponents = {"guide_scaling_exponent", "sheath_scaling_exponent"}
    assert result.keys() >= exponents | {"thread_speedup", "callback_ratio", "threads", "cores"}
    assert result["cost_parts"]["empty_plugin_s"] is not None
    assert result["callback"]["largest_tension_difference"] < 1e-9
    assert result["callback"].keys() >= {"ratio", "callback_added_s", "plugin_added_s"}
    assert result["callback_ratio"] > 1.0
    assert result["frictionloss"]["output_tension"]["max_relative_error"] > 0.1
    for picture in ("scaling", "parts"):
        assert (tmp_path / f"{picture}.png").stat().st_size > 10_000
    assert "floor: an empty plugin" in capsys.readouterr().out
    with refusing(InvalidValueError, "rounds = 0"):  # before anything is timed
        run_benchmark(rounds=0)


TIME = np.linspace(0.0, 1.0, 1500)
NO_PERIOD = 4e-4 * sum(np.sin(2.0 * np.pi * rate * TIME) for rate in (1.0, np.sqrt(2.0), np.e))


@pytest.mark.parametrize("guides", [1, 2, 16, 40])
@pytest.mark.parametrize(("friction", "wave"), [(0.02, WAVE), (0.15, NO_PERIOD), (0.6, WAVE)])
def test_its_tensions_are_the_plugin_s(guides, friction, wave):
    assert disagreement(Bench(guides=guides, friction=friction), wave) < 1e-9


def test_every_guide_keeps_the_capstan_law_and_does_so_again_after_a_reset():
    bench = Bench(guides=12)
    model = bare_bench(bench).compile()
    sheath, ends = NumpySheath(model, bench), []
    most = bench.exponent / bench.guides
    with as_passive_callback(sheath):
        for _ in range(2):
            sheath.reset()
            data = mujoco.MjData(model)
            for control in WAVE:
                data.ctrl[0] = control
                mujoco.mj_step(model, data)
                fall = np.log(sheath.tension[:-1] / sheath.tension[1:])
                assert np.abs(fall).max() <= most * (1.0 + 1e-9)
            ends.append(sheath.tension.copy())
    assert sheath.unsolved == 0
    np.testing.assert_array_equal(*ends)


def test_the_process_has_no_callback_afterwards_and_keeps_another_s():
    def fail():
        with as_passive_callback(lambda m, d: None):
            assert mujoco.get_mjcb_passive() is not None
            raise RuntimeError

    with pytest.raises(RuntimeError):
        fail()
    assert mujoco.get_mjcb_passive() is None

    def theirs(model, data):
        """Of another."""

    mujoco.set_mjcb_passive(theirs)
    try:
        with refusing(EngineError, "already has an mjcb_passive"), as_passive_callback(theirs):
            pass
        assert mujoco.get_mjcb_passive() is theirs
    finally:
        mujoco.set_mjcb_passive(None)


def coulomb(pulled, start, force):
    """T_out behind one force, whatever the tension."""
    behind = itertools.accumulate(
        pulled, lambda now, t: min(max(now, t - force), t + force), initial=start
    )
    return np.array([*behind][1:])


def test_the_motor_s_tension_is_between_half_and_twice_the_mean_and_arrives_without_friction():
    levels = [PULLED[0], PULLED.max(), PULLED.min()]
    assert levels == pytest.approx(np.multiply(BENCH.pretension, [1.0, 2.0, 0.5]), rel=1e-5)
    result = output_tension(motor_bench(BENCH, friction=0.0), PULLED)
    np.testing.assert_allclose(result, PULLED, rtol=1e-12)


def test_a_stiff_frictionloss_is_one_force_whatever_the_tension():
    result = output_tension(motor_bench(BENCH, frictionloss=FORCE, stiff=True), PULLED)
    expected = coulomb(PULLED, BENCH.pretension, FORCE)
    assert np.quantile(np.abs(result - expected), 0.95) < 0.02 * FORCE
    assert np.abs(result - PULLED).max() == pytest.approx(FORCE, rel=1e-6)


def test_the_capstan_law_deviates_from_itself_by_nothing():
    exact = theory.output_tension(PULLED, BENCH.exponent, BENCH.pretension)
    assert deviation(PULLED, exact, BENCH).largest == 0.0
    assert deviation(PULLED, 1.1 * exact, BENCH).rms == pytest.approx(0.1)


def test_the_sheath_follows_the_capstan_law_and_frictionloss_does_not():
    result = compare_frictionloss(BENCH, rounds=1)
    assert result.force == pytest.approx(BENCH.pretension * (1.0 - math.exp(-BENCH.exponent)))
    assert result.sheath_error.largest < 0.002
    # T_in − F where F is right at half of T_in: (1 + e^{−λ})/2 over e^{−λ}
    ratio = 0.5 * (1.0 + math.exp(BENCH.exponent))
    assert result.error.at_most == pytest.approx(ratio - 1.0, abs=0.01)
    assert result.error.largest >= result.error.rms > 0.1
    assert result.default_error.largest > result.error.largest


def test_rollouts_are_compared_for_each_number_of_threads():
    speedups = thread_speedups(Bench(guides=4), (2, 3), rounds=1, runs=4, steps=200)
    assert set(speedups) == {2, 3}  # the same as on one thread to the bit, or it had refused
    assert min(speedup.median for speedup in speedups.values()) > 0.0
