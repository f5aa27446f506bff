"""`python -m experiments.kaneko1991`: Figs. 4 and 5 of Kaneko and others (1991) by six routes."""

from __future__ import annotations

import sys
from pathlib import Path

from experiments.command import run_experiment
from experiments.kaneko1991.agreement import check_histories
from experiments.kaneko1991.figures import draw_figures
from experiments.kaneko1991.numbers_page import numbers_page
from experiments.kaneko1991.reproduction import reproduce
from experiments.kaneko1991.result import result
from tendon_mj.cli import Output, console, progress_bar


def kaneko1991(out: Path = Path("out/kaneko1991"), histories: int = 100) -> None:
    """Reproduce Figs. 4 and 5 of Kaneko and others (1991) by six routes, and compare the routes.

    Takes about two minutes on two cores.

    Args:
        out: folder for result.json, numbers.md and the pictures.
        histories: random histories that the routes are compared on, ≥ 0.
    """
    check_histories(histories)
    output = Output(out)
    with progress_bar() as progress:
        reproduction = reproduce(histories, progress)
    for name, figure in draw_figures(reproduction):
        output.figure(name, figure)
    page = out / "numbers.md"
    page.write_text(numbers_page(reproduction), encoding="utf-8")
    output.add(page)
    output.result(result(reproduction))
    console.print(
        f"routes differ by at most {reproduction.agreement.largest:.2%} of range in T_out and "
        f"{reproduction.agreement.largest_input:.2%} in T_in; slopes of Fig. 4 (a) within "
        f"{reproduction.figure_4a.slope_error:.2%} of K_ap",
        soft_wrap=True,
    )
    output.close()


if __name__ == "__main__":
    sys.exit(run_experiment(kaneko1991, "kaneko1991"))
