"""Writes what the paper's reproduction found: pictures, a page of numbers, a plain dictionary."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from experiments.kaneko1991 import charts
from experiments.kaneko1991 import loop_figures as loops
from experiments.kaneko1991.agreement import Agreement, check_histories
from experiments.kaneko1991.loop import LoopNumbers
from experiments.kaneko1991.reproduction import Paper, reproduce
from experiments.kaneko1991.rig import WHY
from tendon_mj.errors import InvalidValueError
from tendon_mj.progress import Progress, silent


def run_paper(out: Path, progress: Progress = silent, histories: int = 100) -> dict[str, Any]:
    """Reproduce the paper; write the pictures and ``numbers.md`` into ``out``.

    Args:
        out: folder, made if it is not there.
        progress: called with what is being done, how much is done and how much there is.
        histories: random histories on which the routes are compared.

    Returns:
        Plain numbers in SI units, for `result.json`.

    Raises:
        InvalidValueError: ``out`` is a file, or fewer than 0 histories.
    """
    if out.exists() and not out.is_dir():
        raise InvalidValueError(f"{out} is a file; it must be a folder")
    check_histories(histories)
    out.mkdir(parents=True, exist_ok=True)
    found = reproduce(histories, progress)
    low, high = found.stiction.loops
    figures = {
        "agreement": charts.agreement_figure(found.agreement),
        "refinement": charts.refinement_figure(found.refinement),
        "figure_4a": loops.figure_4a(found.figure4a),
        "figure_4b": loops.figure_4bc(found.stiction, low, "b"),
        "figure_4c": loops.figure_4bc(found.stiction, high, "c"),
        "stiction": charts.stiction_figure(found.stiction),
        "figure_5": loops.figure_5(found.figure5),
        "cost": charts.cost_figure(found.costs),
    }
    for done, (name, figure) in enumerate(figures.items()):
        figure.savefig(out / f"{name}.png")
        progress("pictures", done + 1, len(figures))
    (out / "numbers.md").write_text(numbers_page(found), encoding="utf-8")
    return found.result()


def numbers_page(found: Paper) -> str:
    """The tables as a Markdown page."""
    slow, spring = found.figure4a, found.figure5
    parts = ["# The paper's figures in numbers", "Chosen, since the paper does not say:", ""]
    parts += [f"- {name}: {reason}" for name, reason in WHY.items()]
    parts += ["", *_agreement_table(found.agreement)]
    parts += ["", "## Fig. 4 (a)", slow.rig.caption() + ".", ""]
    parts += _loop_table(slow.theory, slow.numbers)
    parts += ["", f"Largest difference of T_out between routes: {slow.largest:.2%} of range.", ""]
    parts += ["| without friction | departure from Hooke's line, over the range |", "|---|---|"]
    parts += [f"| {name} | {gap:.1e} |" for name, gap in slow.straight.items()]
    for rig, theory, numbers, largest in zip(
        spring.rigs, spring.theory, spring.numbers, spring.largest, strict=True
    ):
        parts += ["", f"## Fig. 5, F_c = {rig.constant_friction:g} N", rig.caption() + ".", ""]
        parts += _loop_table(theory, numbers)
        parts += ["", f"Largest difference of T_out between routes: {largest:.2%} of range."]
    gone = spring.departure
    parts += [
        "",
        f"F_c moves T_out at the same ξ_in by {gone.travel_pulling:+.3f} N pulling and "
        f"{gone.travel_loosening:+.3f} N loosening, at the same T_in by "
        f"{gone.tension_pulling:+.3f} N and {gone.tension_loosening:+.3f} N, on every point of the "
        "branches. The lower flat from slack: "
        + " … ".join(f"{1e3 * end:.2f}" for end in gone.lower_flat)
        + " mm without, "
        + " … ".join(f"{1e3 * end:.2f}" for end in gone.lower_flat_with)
        + " mm with F_c.",
    ]
    parts += ["", "## Fig. 4 (b), (c): shift by static friction, over the range", ""]
    parts += ["| tendon | Hz | mean | least | most | phase | rms | steps h [µs] | drag |", ""]
    parts[-1] = "|---|---|---|---|---|---|---|---|---|"
    for s in found.stiction.shifts:
        steps = ", ".join(f"{1e6 * h:g}" for h in s.tendon.steps)
        parts.append(
            f"| {s.tendon.name} | {s.frequency:g} | {s.largest.mean():.1%} | {s.largest.min():.1%} "
            f"| {s.largest.max():.1%} | {s.phase.min():.3f} … {s.phase.max():.3f} "
            f"| {s.rms.mean():.2%} | {steps} | {s.drag:.1%} |"
        )
    still = found.stiction
    parts += ["", "Largest in each of three periods, and where, by the time step:", ""]
    parts += ["| tendon | Hz | h [µs] | shift | phase |", "|---|---|---|---|---|"]
    for s in still.shifts:
        for h, shift, phase in zip(s.tendon.steps, s.largest, s.phase, strict=True):
            parts.append(
                f"| {s.tendon.name} | {s.frequency:g} | {1e6 * h:g} "
                f"| {', '.join(f'{v:.1%}' for v in shift)} "
                f"| {', '.join(f'{v:.3f}' for v in phase)} |"
            )
    parts += ["", "No inertia, the closed form's T_out switching at phases "]
    parts[-1] += " and ".join(f"{at:.3f}" for at in still.switches) + ":"
    parts += ["", "| guides | shift | phase |", "|---|---|---|"]
    parts += [
        f"| {n:g} | {shift:.1%} | {at:.3f} |"
        for n, shift, at in zip(
            still.guides, still.quasi_static, still.quasi_static_phase, strict=True
        )
    ]
    parts += ["", "## Wall time", "Best of three runs, one thread.", ""]
    parts += ["| route | wall time per simulated second [s] | step [ms] | n | error | inertia |"]
    parts += ["|---|---|---|---|---|---|"]
    parts += [
        f"| {c.route} | {c.seconds:.1e} | {1e3 * c.step:.3g} | {c.elements or '–'} "
        f"| {c.error:.2%} | {c.inertia} |"
        for c in found.costs
    ]
    return "\n".join(parts) + "\n"


def _agreement_table(found: Agreement) -> list[str]:
    rows = ["## Largest difference between two routes, over the range", ""]
    rows += ["| history | T_out | T_in |", "|---|---|---|"]
    for name, table in found.difference.items():
        rows.append(f"| {name} | {table.max():.2%} | {found.input_difference[name].max():.2%} |")
    return rows


def _loop_table(theory: LoopNumbers, numbers: Mapping[str, LoopNumbers]) -> list[str]:
    head = ("slope pulling [N/m]", "loosening [N/m]", "ratio pulling", "loosening", "backlash [µm]")
    rows = ["| | " + " | ".join(head) + " |", "|---" * (len(head) + 1) + "|"]
    for name, n in {"**formula**": theory, **numbers}.items():
        rows.append(
            f"| {name} | {n.slope_pulling:.0f} | {n.slope_loosening:.0f} | {n.ratio_pulling:.4f} "
            f"| {n.ratio_loosening:.4f} | {1e6 * n.backlash:.1f} |"
        )
    return rows
