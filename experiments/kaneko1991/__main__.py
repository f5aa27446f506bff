"""`python -m experiments.kaneko1991`: the paper's figures by six routes.

Closed form, continuum, sheath and elements share no code with each other; the plugin and the
elements in MuJoCo contain the sheath. `docs/routes.md` says which agreement is evidence of what.
"""

from __future__ import annotations

from pathlib import Path

import tyro

from experiments.kaneko1991.report import run_paper
from tendon_mj.cli.output import Output, progress_bar


def paper(out: Path = Path("out/kaneko1991"), histories: int = 100) -> dict[str, object]:
    """Reproduce the paper's Figs. 4 and 5 by every route, and say how far the routes are apart.

    Args:
        out: folder for result.json, numbers.md and the pictures.
        histories: random histories that the routes are compared on, ≥ 0.
    """
    output = Output(out)
    with progress_bar() as progress:
        result = run_paper(out, progress, histories)
    output.written = sorted([*out.glob("*.png"), *out.glob("*.md")])
    output.result(result)
    output.close()
    return result


if __name__ == "__main__":
    tyro.cli(paper)
