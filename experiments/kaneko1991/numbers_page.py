"""Tables of the reproduction as a Markdown page, `numbers.md`."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from experiments.kaneko1991.agreement import Agreement
from experiments.kaneko1991.cost import Cost
from experiments.kaneko1991.figure_4a import Figure4a
from experiments.kaneko1991.figure_4bc import Figure4bc, Shift
from experiments.kaneko1991.figure_5 import Departure, Figure5
from experiments.kaneko1991.loop import LoopMeasures
from experiments.kaneko1991.paper_tendon import REASONS
from experiments.kaneko1991.reproduction import Reproduction


def numbers_page(reproduction: Reproduction) -> str:
    """Text of the page."""
    lines = ["# The paper's figures in numbers", "Chosen, since the paper does not say:", ""]
    lines += [f"- {name}: {reason}" for name, reason in REASONS.items()]
    lines += ["", *_agreement(reproduction.agreement)]
    lines += ["", *_figure_4a(reproduction.figure_4a)]
    lines += ["", *_figure_5(reproduction.figure_5)]
    lines += ["", *_figure_4bc(reproduction.figure_4bc)]
    lines += ["", *_costs(reproduction.costs)]
    return "\n".join(lines) + "\n"


def _table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> list[str]:
    lines = ["| " + " | ".join(head) + " |", "|---" * len(head) + "|"]
    return lines + ["| " + " | ".join(row) + " |" for row in rows]


def _agreement(agreement: Agreement) -> list[str]:
    rows = (
        (name, f"{table.max():.2%}", f"{agreement.input_difference[name].max():.2%}")
        for name, table in agreement.difference.items()
    )
    return [
        "## Largest difference between two routes, over the range",
        "",
        *_table(("history", "T_out", "T_in"), rows),
    ]


def _loops(predicted: LoopMeasures, measured: Mapping[str, LoopMeasures]) -> list[str]:
    head = ("", "slope pulling [N/m]", "loosening [N/m]", "ratio pulling", "loosening")
    rows = (
        (
            name,
            f"{loop.slope_pulling:.0f}",
            f"{loop.slope_loosening:.0f}",
            f"{loop.ratio_pulling:.4f}",
            f"{loop.ratio_loosening:.4f}",
            f"{1e6 * loop.backlash:.1f}",
        )
        for name, loop in {"**formula**": predicted, **measured}.items()
    )
    return _table((*head, "backlash [µm]"), rows)


def _figure_4a(data: Figure4a) -> list[str]:
    departures = ((name, f"{value:.1e}") for name, value in data.nonlinearity.items())
    return [
        "## Fig. 4 (a)",
        data.tendon.caption() + ".",
        "",
        *_loops(data.predicted, data.measured),
        "",
        f"Largest difference of T_out between routes: {data.largest:.2%} of range.",
        "",
        *_table(("without friction", "departure from Hooke's law, over the range"), departures),
    ]


def _figure_5(data: Figure5) -> list[str]:
    lines = []
    for tendon, predicted, measured, largest in zip(
        data.tendons, data.predicted, data.measured, data.largest, strict=True
    ):
        lines += [f"## Fig. 5, F_c = {tendon.constant_friction:g} N", tendon.caption() + ".", ""]
        lines += _loops(predicted, measured)
        lines += ["", f"Largest difference of T_out between routes: {largest:.2%} of range.", ""]
    return [*lines, _departure(data.departure)]


def _departure(departure: Departure) -> str:
    flats = (
        " … ".join(f"{1e3 * end:.2f}" for end in flat)
        for flat in (departure.lower_flat, departure.lower_flat_with)
    )
    without, with_friction = flats
    return (
        f"F_c moves T_out at the same ξ_in by {departure.travel_pulling:+.3f} N pulling and "
        f"{departure.travel_loosening:+.3f} N loosening, at the same T_in by "
        f"{departure.tension_pulling:+.3f} N and {departure.tension_loosening:+.3f} N, on every "
        f"point of the branches. The lower flat from slack: {without} mm without, "
        f"{with_friction} mm with F_c."
    )


def _figure_4bc(data: Figure4bc) -> list[str]:
    switches = " and ".join(f"{phase:.3f}" for phase in data.switches)
    head = ("elements", "Hz", "mean", "least", "most", "phase", "rms", "steps h [µs]", "drag")
    guides = zip(data.guides, data.quasi_static, data.quasi_static_phase, strict=True)
    return [
        "## Fig. 4 (b), (c): shift by static friction, over the range",
        "",
        *_table(head, map(_shift, data.shifts)),
        "",
        "Largest in each of three periods, and where, by the time step:",
        "",
        *_table(("elements", "Hz", "h [µs]", "shift", "phase"), _by_step(data.shifts)),
        "",
        f"No inertia, the closed form's T_out switching at phases {switches}:",
        "",
        *_table(
            ("guides", "shift", "phase"),
            ((f"{n:g}", f"{shift:.1%}", f"{phase:.3f}") for n, shift, phase in guides),
        ),
    ]


def _shift(shift: Shift) -> tuple[str, ...]:
    return (
        shift.dynamics.name,
        f"{shift.frequency:g}",
        f"{shift.largest.mean():.1%}",
        f"{shift.largest.min():.1%}",
        f"{shift.largest.max():.1%}",
        f"{shift.phase.min():.3f} … {shift.phase.max():.3f}",
        f"{shift.rms.mean():.2%}",
        ", ".join(f"{1e6 * step:g}" for step in shift.dynamics.steps),
        f"{shift.drag:.1%}",
    )


def _by_step(shifts: Iterable[Shift]) -> Iterable[tuple[str, ...]]:
    for result in shifts:
        by_step = zip(result.dynamics.steps, result.largest, result.phase, strict=True)
        for step, largest, phase in by_step:
            yield (
                result.dynamics.name,
                f"{result.frequency:g}",
                f"{1e6 * step:g}",
                ", ".join(f"{value:.1%}" for value in largest),
                ", ".join(f"{value:.3f}" for value in phase),
            )


def _costs(costs: Iterable[Cost]) -> list[str]:
    head = ("route", "wall time per simulated second [s]", "step [ms]", "n", "error", "inertia")
    rows = (
        (
            cost.route,
            f"{cost.seconds:.1e}",
            f"{1e3 * cost.step:.3g}",
            str(cost.elements or "–"),
            f"{cost.error:.2%}",
            cost.inertia,
        )
        for cost in costs
    )
    return ["## Wall time", "Best of three runs, one thread.", "", *_table(head, rows)]
