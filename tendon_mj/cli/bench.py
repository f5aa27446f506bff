"""`tendon-mj bench`: cost of a step with sheaths."""

from __future__ import annotations

import os
from pathlib import Path

import tyro

from tendon_mj.cli.options import given_files
from tendon_mj.cli.output import Output, console, print_table, progress_bar
from tendon_mj.lab.verification import ModelCost, measure_models
from tendon_mj.show import bars_figure

_HEAD = ("model", "sheaths", "step [µs]", "without", "ratio", "quartiles", "state [kB]")


def bench(
    models: tyro.conf.Positional[tuple[str, ...]] = (),
    out: Path = Path("out/bench"),
    rounds: int = 15,
) -> dict[str, object]:
    """Measure the cost of a step with sheaths, on bench, finger and given models.

    Args:
        models: MJCF files; friction 0.1 is added to every tendon of each, and its step is compared
            with the same model's without.
        out: folder for result.json and the picture.
        rounds: of every measurement; each round times all that is compared, in turns.

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
    output.result(result)
    print_table(_HEAD, [_row(name, model) for name, model in costs.items()])
    console.print("state: of the sheaths, in each simulation; result.json has all of an MjData")
    for name, model in costs.items():
        if model.unsensed:
            ratio = model.unsensed.ratios
            console.print(
                f"{name} without the sensors of tension: {ratio.median:.2f} × "
                f"({ratio.low:.2f} … {ratio.high:.2f})"
            )
    least, most = (pick(ratios, key=ratios.__getitem__) for pick in (min, max))
    output.close(
        f"With sheaths a step takes {ratios[least]:.2f} ({least}) to {ratios[most]:.2f} ({most}) "
        "times as long as without."
    )
    return result


def _row(name: str, model: ModelCost) -> tuple[str, ...]:
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
