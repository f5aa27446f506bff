"""Figure of predicted and measured load over time, for recordings that no fit has seen."""

from __future__ import annotations

from matplotlib.figure import Figure

from experiments.cable_tool.cross_validation import LEFT_OUT
from experiments.cable_tool.fit import fit_tool
from experiments.cable_tool.study import Study
from tendon_mj.show import BLUE, GREY, SKY, VERMILLION, legend_below, new_figure, print_style

_SHOWN = 10.5  # [s]


def draw_prediction(found: Study) -> Figure:
    """Draw one recording of each group: its wrist pose, or load, left out of the fit.

    Of each group the one of median error is shown.
    """
    with print_style():
        figure = new_figure(7.4, 7.0)
        groups = [g for g in ("straight", "pitch", "roll") if found.chosen("pose", g)]
        panels = figure.subplots(len(groups), 1, sharex=True, squeeze=False)[:, 0]
        for axes, group in zip(panels, groups, strict=True):
            kind = "load" if group == "straight" else "pose"
            value = LEFT_OUT[kind]
            errors = sorted(found.chosen(kind, group), key=lambda one: one.torque)
            one = errors[len(errors) // 2]
            recording = next(r for r in found.recordings if r.name == one.name)
            tool = fit_tool([r for r in found.recordings if value(r) != value(recording)])
            shown = recording.time <= _SHOWN
            time = recording.time[shown]
            axes.plot(
                time,
                1e3 * recording.input_torque[shown],
                color=SKY,
                linewidth=1.0,
                label="input torque",
            )
            axes.plot(
                time, 1e3 * recording.load[shown], color=GREY, linewidth=2.6, label="measured load"
            )
            axes.plot(
                time,
                1e3 * tool.load(recording)[shown],
                "--",
                color=VERMILLION,
                label="predicted load",
            )
            axes.axhline(0.0, color=BLUE, linewidth=0.5)
            axes.set(
                ylabel="torque [mN m]",
                title=f"{recording.name.replace('_', ' ')}, its {kind} left out: "
                f"{1e3 * one.torque:.1f} mN m rms",
            )
        panels[-1].set_xlabel("time [s]")
        legend_below(figure, panels[0], columns=3)
    return figure
