"""`tendon-mj compare`: MuJoCo's tendon against the closed form of the 1991 paper."""

from __future__ import annotations

from pathlib import Path

from tendon_mj.cli.output import Output, console, progress_bar
from tendon_mj.lab.verification import SWING, Comparison, LargestErrors, compare_bench
from tendon_mj.show import convergence_figure, loops_figure, sweep_figure

_REMAINDER = (
    "the remainder is finite strain T/EA and finite travel ξ/L, which the closed form neglects, "
    "and the guides' spacing, (λ/n)²; in the limit (EA, k_e, k_s × 100, 64 guides) it vanishes"
)


def compare(out: Path = Path("out/compare")) -> dict[str, object]:
    """Compare MuJoCo's response on the bench with K_ap, ξ_B and K_t of the closed form.

    Args:
        out: folder for result.json and the pictures.

    Example:
        tendon-mj compare --out out/compare
    """
    output = Output(out)
    with progress_bar() as progress:
        comparison = compare_bench(progress=progress)
    result = comparison.result()
    convergence = comparison.convergence
    output.figure("loops", loops_figure(comparison.bench, comparison.loop))
    output.figure("sweep", sweep_figure(comparison.motions))
    output.figure("limit", sweep_figure(comparison.limit_motions))
    output.figure(
        "convergence",
        convergence_figure(convergence.guides, convergence.error, convergence.order),
    )
    output.result(result)
    _print_summary(comparison)
    errors = LargestErrors.of(comparison.motions)
    output.close(
        "On the bench the apparent stiffness agrees with the closed form within "
        f"{errors.apparent_stiffness:.2%}, and the equivalent backlash within "
        f"{errors.backlash:.2%} of T_in L/EA."
    )
    return result


def _print_summary(comparison: Comparison) -> None:
    for label, bench, motions in (
        ("bench", comparison.bench, comparison.motions),
        ("limit", comparison.limit_bench, comparison.limit_motions),
    ):
        errors = LargestErrors.of(motions)
        console.print(
            f"{label}, {bench.guides} guides, |λ| ≤ {errors.exponent:g}, both directions, "
            f"output tension ±{SWING:.0%}: "
            f"K_ap within {errors.apparent_stiffness:.3%}, ξ_B within "
            f"{errors.backlash:.4%} of T_in L/EA, T_out/T_in within {errors.transmission:.0e}"
        )
    console.print(f"  ({_REMAINDER})")
    kt = comparison.transmission_stiffness
    console.print(f"loop on the bench: K_t off by {kt[1]:+.2%} pulling and {kt[-1]:+.2%} loosening")
    console.print(
        f"convergence over the guides: order {comparison.convergence.order:.2f}; "
        f"a step costs {comparison.step_cost:.2f} × that of MuJoCo's own tendon; rollouts on two "
        f"threads are {comparison.rollout_speedup:.2f} × as fast as on one, and the same to the "
        "bit"
    )
