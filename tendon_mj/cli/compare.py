"""`tendon-mj compare`: MuJoCo's tendon against the paper's closed form."""

from __future__ import annotations

from pathlib import Path

from matplotlib.figure import Figure

from tendon_mj.cli.output import Output, console, progress_bar
from tendon_mj.verification.comparison import Comparison
from tendon_mj.verification.comparison import compare as measure
from tendon_mj.verification.first_motion import SWING, Motion
from tendon_mj.view.figures.convergence import convergence_figure
from tendon_mj.view.figures.loops import bench_loops_figure
from tendon_mj.view.figures.sweep import sweep_figure

_LEFT = (
    "what is left is finite strain T/EA and finite travel ξ/L, which the closed form neglects, and "
    "the spacing of the guides, (λ/n)²; in the limit (EA, k_e, k_s × 100, 64 guides) it vanishes"
)


def compare(out: Path = Path("out/compare")) -> dict[str, object]:
    """Hold MuJoCo's response on the bench against K_ap, ξ_B and K_t of the closed form.

    Args:
        out: folder for result.json and the pictures.
    """
    output = Output(out)
    with progress_bar() as progress:
        comparison = measure(progress=progress)
    result = comparison.result()
    _draw(comparison, output)
    output.result(result)
    _say(comparison)
    output.close()
    return result


def _draw(comparison: Comparison, output: Output) -> None:
    output.figure("loops", bench_loops_figure(comparison.bench, comparison.loop))
    output.figure("sweep", _sweep(comparison.motions))
    output.figure("limit", _sweep(comparison.limit_motions))
    found = comparison.convergence
    output.figure("convergence", convergence_figure(found.guides, found.error, found.order))


def _sweep(motions: list[Motion]) -> Figure:
    ordered = sorted(motions, key=lambda motion: motion.exponent)
    return sweep_figure(
        exponent=[m.exponent for m in ordered],
        apparent_stiffness=[m.apparent_stiffness for m in ordered],
        analytic_stiffness=[m.analytic_stiffness for m in ordered],
        backlash=[m.backlash for m in ordered],
        analytic_backlash=[m.analytic_backlash for m in ordered],
        backlash_error=[m.backlash_error for m in ordered],
    )


def _say(comparison: Comparison) -> None:
    for label, motions in (
        (f"bench, {comparison.bench.guides} guides", comparison.motions),
        (f"limit, {comparison.limit_bench.guides} guides", comparison.limit_motions),
    ):
        stiffness = max(abs(m.stiffness_error) for m in motions)
        backlash = max(abs(m.backlash_error) for m in motions)
        slid = max(abs(m.transmission / m.analytic_transmission - 1.0) for m in motions)
        top = max(m.exponent for m in motions)
        console.print(
            f"{label}, |λ| ≤ {top:g}, both directions, output tension ±{SWING:.0%}: "
            f"K_ap within {stiffness:.3%}, ξ_B within "
            f"{backlash:.4%} of T_in L/EA, T_out/T_in within {slid:.0e}"
        )
    console.print(f"  ({_LEFT})")
    kt = comparison.transmission_stiffness
    console.print(f"loop on the bench: K_t off by {kt[1]:+.2%} pulling and {kt[-1]:+.2%} loosening")
    console.print(
        f"convergence over the guides: order {comparison.convergence.order:.2f}; "
        f"a step costs {comparison.step_cost:.2f} × that of MuJoCo's own tendon; rollouts on two "
        f"threads are {comparison.rollout_speedup:.2f} × as fast as on one, and the same to the bit"
    )
