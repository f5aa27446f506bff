"""`tendon-mj bench` and `compare`: cost of a step, and MuJoCo against the closed form of 1991."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated

import tyro

from tendon_mj.cli.options import given_files
from tendon_mj.cli.output import Output, console, print_table, progress_bar
from tendon_mj.lab.bench_comparison import SWING, Comparison, LargestErrors, compare_bench
from tendon_mj.lab.step_cost import ModelCost, measure_models
from tendon_mj.show import bars_figure, convergence_figure, loops_figure, sweep_figure

_COST_HEAD = ("model", "sheaths", "step [µs]", "without", "ratio", "quartiles", "state [kB]")
Models = Annotated[
    tuple[str, ...], tyro.conf.Positional, tyro.conf.arg(help_behavior_hint="(optional)")
]
_REMAINDER = (
    "the remainder is finite strain T/EA and finite travel ξ/L, which the closed form neglects, "
    "and the guides' spacing, (λ/n)²; in the limit (EA, k_e, k_s × 100, 64 guides) it vanishes"
)


def bench(
    models: Models = (),
    out: Path = Path("out/bench"),
    rounds: int = 15,
) -> dict[str, object]:
    """Measure the cost of a step with sheaths, on bench, finger and given models.

    Args:
        models: MJCF files. Friction 0.1 is added to every tendon of a file without sheaths; the
            step is compared with that of the same model without friction.
        out: Folder for result.json and the picture.
        rounds: Rounds of every measurement. A round times all models in turn.

    Example:
        tendon-mj bench hand.xml --rounds 5
    """
    output = Output(out, given=given_files(models=models))
    with progress_bar() as progress:
        costs = measure_models(models, rounds=rounds, progress=progress)
    spreads = {name: model.cost.ratios for name, model in costs.items()}
    figure = bars_figure(
        {name: (ratio.low, ratio.median, ratio.high) for name, ratio in spreads.items()},
        "{:.2f} ×",
        title="a step of each model",
        label="cost with sheaths over cost without [–]",
        reference=(1.0, "without sheaths"),
    )
    output.figure("cost", figure)
    ratios = {name: ratio.median for name, ratio in spreads.items()}
    result: dict[str, object] = {
        "step_cost_ratio": ratios,
        "models": {name: model.result() for name, model in costs.items()},
        "cores": os.cpu_count(),
    }
    print_table(_COST_HEAD, [_cost_row(name, model) for name, model in costs.items()])
    console.print("state: of the sheaths, in each simulation; result.json has all of an MjData")
    for name, model in costs.items():
        if model.unsensed:
            ratio = model.unsensed.ratios
            console.print(
                f"{name} without the sensors of tension: {ratio.median:.2f} × "
                f"({ratio.low:.2f} … {ratio.high:.2f})"
            )
    least, most = (pick(ratios, key=ratios.__getitem__) for pick in (min, max))
    sentence = (
        f"With sheaths a step takes {ratios[least]:.2f} ({least}) to {ratios[most]:.2f} ({most}) "
        "times as long as without."
    )
    return output.finish(result, sentence)


def _cost_row(name: str, model: ModelCost) -> tuple[str, ...]:
    cost, ratios = model.cost, model.cost.ratios
    return (
        name,
        f"{model.sheaths}",
        f"{cost.step * 1e6:.2f}",
        f"{cost.reference_step * 1e6:.2f}",
        f"{ratios.median:.2f}",
        f"{ratios.low:.2f} … {ratios.high:.2f}",
        f"{model.memory['plugin_state'] / 1e3:.1f}",
    )


def compare(out: Path = Path("out/compare")) -> dict[str, object]:
    """Compare MuJoCo's response on the bench with K_ap, ξ_B and K_t of the closed form.

    Args:
        out: Folder for result.json and the pictures.

    Example:
        tendon-mj compare --out out/compare
    """
    output = Output(out)
    with progress_bar() as progress:
        comparison = compare_bench(progress=progress)
    convergence = comparison.convergence
    output.figure("loops", loops_figure(comparison.bench, comparison.loop))
    output.figure("sweep", sweep_figure(comparison.motions))
    output.figure("limit", sweep_figure(comparison.limit_motions))
    output.figure(
        "convergence", convergence_figure(convergence.guides, convergence.error, convergence.order)
    )
    _print_comparison(comparison)
    errors = LargestErrors.of(comparison.motions)
    sentence = (
        "On the bench the apparent stiffness agrees with the closed form within "
        f"{errors.apparent_stiffness:.2%}, and the equivalent backlash within "
        f"{errors.backlash:.2%} of T_in L/EA."
    )
    return output.finish(comparison.result(), sentence)


def _print_comparison(comparison: Comparison) -> None:
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
    order = comparison.convergence.order
    console.print(f"convergence over the guides: order {order:.2f}")
