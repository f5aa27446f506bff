"""The panel beside the scene in a browser: tensions as numbers and curves, sliders, buttons."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from tendon_mj.errors import TendonError
from tendon_mj.show.live.colour_key import colour_key, key_height
from tendon_mj.show.live.curve_colours import curve_colours
from tendon_mj.show.live.prepare import Prepared, tendon_names
from tendon_mj.show.live.sliders import FIRST, slider
from tendon_mj.typing import FloatArray

_ALL = "all sheaths"
_MOST = 6  # tendons that have curves
_WIDTH = 400  # of the key of colours [pixels]
_HEIGHT = 230  # of the curves [pixels]
_POINTS = 400  # of a curve
_RESTART = "restart the motion"  # the sliders stay as they are


def tension_table(tendons: Sequence[str], tensions: FloatArray, time: float) -> str:
    """Tensions as a table in Markdown.

    Args:
        tendons: their names.
        tensions: (tendons, 2) at input and output [N].
        time: of the simulation [s].
    """
    rows = ["| tendon | input [N] | output [N] |", "|---|---|---|"]
    for name, (first, last) in zip(tendons, tensions, strict=True):
        rows.append(f"| {name} | {first:.2f} | {last:.2f} |")
    return "\n".join([*rows, "", f"time {time:.1f} s"])


class WebPanel:
    """Numbers, curves, sliders and buttons.

    Args:
        server: viser's.
        viser: its module.
        prepared: what is shown.
    """

    def __init__(self, server: Any, viser: Any, prepared: Prepared) -> None:
        self._gui, self._viser = server.gui, viser
        self._simulation = prepared.simulation
        self._tendons = list(tendon_names(prepared.simulation.model).values())
        self._problem = self._gui.add_markdown("", visible=False)
        if self._tendons:
            self._add_key(prepared)
            self._table = self._gui.add_markdown("")
            self._curves = self._add_curves()
            self._add_sliders()
            self.draw()
        self._add_buttons()

    def draw(self) -> None:
        """Show the tensions as they are now."""
        if not self._tendons:
            return
        times, tensions = self._simulation.curves()
        self._table.content = tension_table(self._tendons, tensions[-1], float(times[-1]))
        chosen = np.unique(np.linspace(0, len(times) - 1, min(len(times), _POINTS)).astype(int))
        rows = np.nan_to_num(tensions[chosen, :_MOST].reshape(len(chosen), -1), posinf=0.0)
        self._curves.data = (times[chosen], *(np.ascontiguousarray(row) for row in rows.T))

    def _add_key(self, prepared: Prepared) -> None:
        limits, none = (prepared.low, prepared.high), np.zeros((0, 2, 3))
        key = colour_key(limits, [], none, _WIDTH, key_height(0))  # the curves have their names
        self._gui.add_image(key, format="png")

    def _add_curves(self) -> Any:
        colours = (255.0 * curve_colours(self._simulation.model)).astype(int)
        series = [self._viser.uplot.Series(label="time [s]")]
        for name, ends in list(zip(self._tendons, colours, strict=True))[:_MOST]:
            for where, (red, green, blue) in zip(("input", "output"), ends, strict=True):
                stroke = f"rgb({red},{green},{blue})"
                label = f"{name} {where}"
                series.append(self._viser.uplot.Series(label=label, stroke=stroke, width=2))
        return self._gui.add_uplot(
            tuple(np.zeros(1) for _ in series),
            tuple(series),
            title="tension at the ends [N] over time [s]",
            scales={"x": self._viser.uplot.Scale(time=False)},
            legend=self._viser.uplot.Legend(show=True, live=False),
            height=_HEIGHT,
        )

    def _add_buttons(self) -> None:
        simulation = self._simulation
        buttons = self._gui.add_button_group("simulation", ("halt or go on", _RESTART))

        @buttons.on_click
        def _(event: Any) -> None:
            if buttons.value == _RESTART:
                simulation.reset()
                self.draw()
            else:
                simulation.paused = not simulation.paused

    def _add_sliders(self) -> None:
        simulation = self._simulation
        names = simulation.sheaths
        chosen = None
        if len(names) > 1:
            chosen = self._gui.add_dropdown("sheath", (_ALL, *names), initial_value=_ALL)

        def sheaths() -> Sequence[str]:
            return names if chosen is None or chosen.value == _ALL else [chosen.value]

        parameters = [
            key.partition(".")[2] for key in simulation.parameters if key.startswith(f"{names[0]}.")
        ]
        handles: dict[str, tuple[Any, float]] = {}
        for parameter in FIRST:
            self._add_slider(parameter, sheaths, handles)
        with self._gui.add_folder("further effects", expand_by_default=False):
            for parameter in parameters:
                if parameter not in handles:
                    self._add_slider(parameter, sheaths, handles)
        if chosen is not None:

            @chosen.on_update
            def _(event: Any) -> None:
                for parameter, (handle, factor) in handles.items():
                    value = simulation.parameters[f"{sheaths()[0]}.{parameter}"]
                    handle.value = factor * value

    def _add_slider(
        self, parameter: str, sheaths: Any, handles: dict[str, tuple[Any, float]]
    ) -> None:
        simulation = self._simulation
        found = slider(parameter, simulation.parameters[f"{sheaths()[0]}.{parameter}"])
        if found is None:
            return
        handle = self._gui.add_slider(
            found.label, found.low, found.high, found.step, found.value, hint=found.hint
        )

        @handle.on_update
        def _(event: Any) -> None:
            if event.client is None:  # set by the choice of a sheath
                return
            try:
                for sheath in sheaths():
                    simulation.set(f"{sheath}.{parameter}", float(handle.value) / found.factor)
                self._problem.visible = False
            except TendonError as error:
                self._problem.content, self._problem.visible = f"**{error}**", True

        handles[parameter] = handle, found.factor
