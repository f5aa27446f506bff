"""Figures carry symbols, units and legends, and draw what they were given."""

import numpy as np
import pytest
from matplotlib import pyplot

from tendon_mj import theory
from tendon_mj.lab.bench_comparison import BenchReadings, FirstMotion
from tendon_mj.models import Bench
from tendon_mj.show import convergence_figure, loops_figure, replay_figure, sweep_figure
from tendon_mj.show.style import column_label, drawn_unit
from tests.lab.recorded import recorded

LAM, T0, EA, L, KSE = 0.47, 20.0, 20e3, 0.5, 8e3


def loops():
    bench = Bench(
        friction=LAM / np.pi,
        length=L,
        axial_stiffness=EA,
        pretension=T0,
        environment_stiffness=2.0 * KSE,
        sensor_stiffness=2.0 * KSE,
    )
    xi = 1.5e-3 * np.sin(np.linspace(0.0, 4.0 * np.pi, 400))
    near, far = theory.driven_tensions(xi, LAM, T0, EA, L, KSE)
    return loops_figure(bench, BenchReadings(near, far, xi, (far - T0) / KSE))


def sweep():
    motions = []
    for lam in (1.0, 0.5, 0.1, -0.1, -0.5, -1.0):
        stiffness = float(theory.apparent_stiffness(lam, EA, L))
        backlash = float(theory.equivalent_backlash(lam, T0, EA, L))
        slid = float(np.exp(-lam))
        motions.append(
            FirstMotion(lam, 1.01 * stiffness, stiffness, backlash, backlash, 0.0, slid, slid)
        )
    return sweep_figure(motions)


def recording(name="rig", angle=1.0):
    time = np.linspace(0.0, 10.0, 200)
    return recorded(
        time,
        {"command_rad": ("command", np.sin(time))},
        {
            "joint_rad": ("joint_angle", None, angle * np.sin(time - 0.3)),
            "speed_rad_per_s": ("speed", None, np.cos(time)),
        },
        "joint",
        name=name,
    )


def replays():
    return replay_figure(recording(), {"friction 0": recording("simulated", 0.5)})


def convergence():
    guides = 2.0 ** np.arange(1, 7)
    return convergence_figure(guides, 0.7 / guides**2, 2.0)


def legend_texts(figure):
    legends = [*figure.legends, *(a.get_legend() for a in figure.axes if a.get_legend())]
    return [text.get_text() for legend in legends for text in legend.get_texts()]


@pytest.mark.parametrize("make", [loops, sweep, convergence, replays])
def test_every_axis_has_a_label_with_its_unit_and_every_figure_a_legend(make, tmp_path):
    figure = make()
    figure.savefig(tmp_path / "figure.png", dpi=160)
    assert (tmp_path / "figure.png").stat().st_size > 10_000
    assert legend_texts(figure)
    for axes in figure.axes:
        if not axes.axison:
            continue
        for axis, labels_shown in ((axes.xaxis, "labelbottom"), (axes.yaxis, "labelleft")):
            if axis.get_tick_params()[labels_shown]:
                assert axis.get_label_text().rstrip().endswith("]"), axis.get_label_text()
    assert not pyplot.get_fignums(), "pyplot knows nothing of it"


@pytest.mark.parametrize("make", [loops, sweep, convergence])
def test_legends_stay_off_the_data(make):
    figure = make()
    figure.draw_without_rendering()
    legend = figure.legends[0].get_window_extent()
    assert not any(legend.overlaps(axes.get_window_extent()) for axes in figure.axes)


def test_the_loops_of_the_closed_form_lie_between_its_lines():
    left, right = loops().axes
    for axes in (left, right):
        lines = [line for line in axes.get_lines() if line.get_linestyle() != "None"]
        loop, pulling, loosening = (line.get_xydata() for line in lines[:3])
        low = np.interp(loop[:, 1], loosening[:, 1], loosening[:, 0])
        high = np.interp(loop[:, 1], pulling[:, 1], pulling[:, 0])
        slack = 1e-6 * np.ptp(loop[:, 0])
        assert (loop[:, 0] >= low - slack).all()
        assert (loop[:, 0] <= high + slack).all()


def test_the_sweep_shows_the_error_it_was_given_in_percent():
    stiffness_error = sweep().axes[2]
    shown = np.concatenate([line.get_ydata() for line in stiffness_error.get_lines()[:2]])
    assert shown == pytest.approx(1.0)


def test_the_sweep_is_relative_to_the_tendon_without_friction():
    curve = sweep().axes[0].get_lines()[0].get_xydata()
    assert np.interp(0.0, *curve.T) == pytest.approx(1.0)


def test_the_replay_states_each_rms_error_with_its_unit():
    texts = legend_texts(replays())
    rmse = np.sqrt(np.mean((0.5 * np.sin(recording().time - 0.3)) ** 2))
    assert f"friction 0\nrms error {np.degrees(rmse):.3g}°" in texts
    assert "friction 0\nrms error 0°/s" in texts


@pytest.mark.parametrize(
    ("column", "largest", "label"),
    [
        ("joint_rad", 0.5, "joint [°]"),
        ("tension_1_N", 20.0, "tension 1 [N]"),
        ("tip_speed_m_per_s", 2.0, "tip speed [m/s]"),
        ("input_displacement_m", 1e-3, "input displacement [mm]"),
        ("torque_Nm", 0.02, "torque [mN m]"),
    ],
)
def test_a_column_is_labelled_with_the_unit_in_which_it_is_read(column, largest, label):
    series = np.array([0.0, -largest, np.nan])
    assert column_label(column, drawn_unit(column, series[:2])) == label
