"""Writes what the paper's reproduction found: pictures, a page of numbers, a plain dictionary."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from tendon_mj.simulate.first_motion import Progress, silent
from tendon_mj.simulate.paper import Paper, reproduce
from tendon_mj.simulate.paper_loop import LoopNumbers
from tendon_mj.simulate.paper_rig import WHY
from tendon_mj.view import paper_charts as charts
from tendon_mj.view import paper_figures as loops


def run_paper(out: Path, progress: Progress = silent, histories: int = 100) -> dict[str, Any]:
    """Reproduce the paper; write the pictures and ``numbers.md`` into ``out``.

    Args:
        out: folder, made if it is not there.
        progress: called with what is being done, how much is done and how much there is.
        histories: random histories on which the routes are compared.

    Returns:
        Plain numbers in SI units, for `result.json`.
    """
    found = reproduce(histories, progress)
    out.mkdir(parents=True, exist_ok=True)
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
    parts += ["", "## Fig. 4 (b), (c): shift by static friction, over the range", ""]
    parts += ["| tendon | Hz | mean | least | most | rms | steps h [µs] | drag |", ""]
    parts[-1] = "|---|---|---|---|---|---|---|---|"
    for s in found.stiction.shifts:
        steps = ", ".join(f"{1e6 * h:g}" for h in s.tendon.steps)
        parts.append(
            f"| {s.tendon.name} | {s.frequency:g} | {s.largest.mean():.1%} | {s.largest.min():.1%} "
            f"| {s.largest.max():.1%} | {s.rms.mean():.2%} | {steps} | {s.drag:.1%} |"
        )
    parts += ["", "## Wall time", ""]
    parts += ["| route | wall time per simulated second [s] | step [ms] | n | error | inertia |"]
    parts += ["|---|---|---|---|---|---|"]
    parts += [
        f"| {c.route} | {c.seconds:.1e} | {1e3 * c.step:.3g} | {c.elements or '–'} "
        f"| {c.error:.2%} | {c.inertia} |"
        for c in found.costs
    ]
    return "\n".join(parts) + "\n"


def _loop_table(theory: LoopNumbers, numbers: Mapping[str, LoopNumbers]) -> list[str]:
    head = ("slope pulling [N/m]", "loosening [N/m]", "ratio pulling", "loosening", "backlash [µm]")
    rows = ["| | " + " | ".join(head) + " |", "|---" * (len(head) + 1) + "|"]
    for name, n in {"**formula**": theory, **numbers}.items():
        rows.append(
            f"| {name} | {n.slope_pulling:.0f} | {n.slope_loosening:.0f} | {n.ratio_pulling:.4f} "
            f"| {n.ratio_loosening:.4f} | {1e6 * n.backlash:.1f} |"
        )
    return rows
