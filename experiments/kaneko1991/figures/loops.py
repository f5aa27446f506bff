"""Loops of all routes overlaid, with the lines of the closed form."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes

from experiments.kaneko1991.figures.style import LOOKS
from experiments.kaneko1991.paper_tendon import PaperTendon
from experiments.kaneko1991.routes import Trace
from tendon_mj.show import BLACK

MILLI = 1e3


def plot_loops(
    axes: Sequence[Axes], traces: Mapping[str, Trace], samples: slice, shift: float = 0.0
) -> None:
    """Plot T_out over ξ_in and over T_in for every route; ``shift`` [m] is taken from ξ_in."""
    for name, trace in traces.items():
        colour, line, width = LOOKS[name]
        look = {"color": colour, "linestyle": line, "linewidth": width, "label": name}
        out = trace.output_tension[samples]
        travel = MILLI * (trace.input_displacement[samples] - shift)
        axes[0].plot(travel, out, **look)  # type: ignore[arg-type]
        axes[1].plot(trace.input_tension[samples], out, **look)  # type: ignore[arg-type]
    axes[0].set(xlabel="input displacement ξ_in [mm]", ylabel="output tension T_out [N]")
    axes[1].set(xlabel="input tension T_in [N]", ylabel="output tension T_out [N]")


def plot_theory(axes: Sequence[Axes], tendon: PaperTendon, shift: float = 0.0) -> None:
    """Plot, dotted, both branches of the closed form and the line without friction."""
    for sign in (1.0, -1.0, 0.0):
        lam, offset = sign * tendon.exponent, tendon.tension_offset
        sliding = tendon if sign else dataclasses.replace(tendon, friction=0.0)
        slope = sliding.transmission_stiffness(sign or 1.0)
        travel = np.array(axes[0].get_xlim()) / MILLI + shift
        line = slope * (travel - tendon.slack_displacement) - offset
        axes[0].plot(MILLI * (travel - shift), line, ":", color=BLACK, lw=0.9)
        tension = np.array(axes[1].get_xlim())
        axes[1].plot(tension, (tension + offset) * np.exp(-lam) - offset, ":", color=BLACK, lw=0.9)


def set_limits(
    axes: Sequence[Axes], traces: Mapping[str, Trace], samples: slice, shift: float
) -> None:
    """Set the limits so that they hold the loops and nothing else."""
    near = np.concatenate([t.input_tension[samples] for t in traces.values()])
    far = np.concatenate([t.output_tension[samples] for t in traces.values()])
    travel = np.concatenate([t.input_displacement[samples] for t in traces.values()]) - shift
    for axis, values in ((axes[0], MILLI * travel), (axes[1], near)):
        margin = 0.05 * float(np.ptp(values))
        axis.set_xlim(values.min() - margin, values.max() + margin)
        axis.set_ylim(far.min() - 0.05 * np.ptp(far), far.max() + 0.05 * np.ptp(far))
