"""`tendon-mj bench`: what sheaths cost a step and a simulation."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import tyro

from experiments.benchmarks import Benchmark, run_benchmark
from experiments.benchmarks.figures import CostSeries, cost_figure, scaling_figure
from experiments.benchmarks.scaling import FAST, SLOW
from tendon_mj.cli.given_files import given_files
from tendon_mj.cli.output import Output, console, print_table, progress_bar
from tendon_mj.lab.verification import ModelCost, Spread

_HEAD = ("model", "sheaths", "step [µs]", "without", "ratio", "quartiles", "state [kB]")
_PARTS = {
    "empty_plugin": "floor: an empty plugin",
    "idle_instance": "+ an idle instance of this one",
    "first_guide": "+ a sheath of one guide, at rest",
    "more_guides": "+ the other guides, at rest",
    "sliding": "+ sliding to and fro",
    "sensors": "+ three sensors",
}


def bench(
    models: Annotated[tuple[str, ...], tyro.conf.Positional] = (),
    out: Path = Path("out/bench"),
    rounds: int = 15,
) -> dict[str, object]:
    """Measure what sheaths cost: on bench and finger, over guides, sheaths and threads.

    Args:
        models: MJCF files; friction 0.1 is added to every tendon of each, and its step is compared
            with the same model's without.
        out: folder for result.json and the pictures.
        rounds: of every measurement; each round times all that is compared, in turns.

    Example:
        tendon-mj bench hand.xml --rounds 5
    """
    output = Output(out, given=given_files(models=models))
    with progress_bar() as progress:
        found = run_benchmark(models, rounds=rounds, progress=progress)
    result = found.result()
    slow, fast = found.guides.slow, found.guides.fast
    scaled = [
        CostSeries(label, one.counts, one.added, one.exponent)
        for label, one in (
            (f"reel at {SLOW:g} Hz", slow),
            (f"reel at {FAST:g} Hz", fast),
            ("benches", found.sheaths),
        )
    ]
    output.figure("scaling", scaling_figure(scaled[:2], scaled[2]))
    ratios = {name: _bars(model.cost.ratios) for name, model in found.models.items()}
    parts = {label: _bars(spread) for label, spread in _parts(found).items()}
    output.figure("cost", cost_figure(ratios, parts))
    output.result(result)
    _print_summary(found)
    output.close(_sentence(found))
    return result


def _sentence(found: Benchmark) -> str:
    ratios = {name: model.cost.ratios.median for name, model in found.models.items()}
    least, most = (pick(ratios, key=ratios.__getitem__) for pick in (min, max))
    return (
        f"With sheaths a step takes {ratios[least]:.2f} ({least}) to {ratios[most]:.2f} ({most}) "
        "times as long as without."
    )


def _bars(spread: Spread) -> tuple[float, float, float]:
    return spread.low, spread.median, spread.high


def _parts(found: Benchmark) -> dict[str, Spread]:
    """Label → what the part adds; without the floor where MuJoCo came without an empty plugin."""
    spreads = {label: getattr(found.parts, name) for name, label in _PARTS.items()}
    return {label: spread for label, spread in spreads.items() if spread is not None}


def _row(name: str, model: ModelCost) -> tuple[str, ...]:
    cost, ratios = model.cost, model.cost.ratios
    return (
        name,
        f"{model.sheaths}",
        f"{cost.step * 1e6:.2f}",
        f"{cost.reference_step * 1e6:.2f}",
        f"{ratios.median:.2f}",
        f"{ratios.low:.2f} … {ratios.high:.2f}",
        f"{model.memory.plugin_state / 1e3:.1f}",
    )


def _print_summary(found: Benchmark) -> None:
    rows = [_row(name, model) for name, model in found.models.items()]
    print_table(_HEAD, rows)
    console.print("state: of the sheaths, in each simulation; result.json has all of an MjData")
    for name, model in found.models.items():
        if model.unsensed:
            console.print(
                f"{name} without the sensors of tension: {_ratio(model.unsensed.ratios)}",
                soft_wrap=True,
            )
    for label, spread in _parts(found).items():
        console.print(f"{label}: {spread.median * 1e9:.0f} ns ({_range(spread, 1e9, '.0f')})")
    console.print(
        f"added cost ∝ guides^{found.guides.slow.exponent:.2f} with the reel at {SLOW:g} Hz, "
        f"^{found.guides.fast.exponent:.2f} at {FAST:g} Hz; "
        f"∝ sheaths^{found.sheaths.exponent:.2f}",
        soft_wrap=True,
    )
    for count, speedup in found.threads.items():
        console.print(f"{count} threads: {_ratio(speedup)}, and the same to the bit")
    callback, loss = found.callback, found.frictionloss
    console.print(
        f"a NumPy mjcb_passive adds {callback.callback.median * 1e6:.0f} µs: "
        f"{_ratio(callback.ratio)} what the plugin adds, "
        f"tensions alike within {callback.disagreement:.0e}",
        soft_wrap=True,
    )
    console.print(
        f"MuJoCo's frictionloss takes {_ratio(loss.over_sheath)} the step of a sheath; T_out is "
        f"off the capstan law by up to {loss.error.largest:.0%} between half and twice the mean "
        f"tension, with the default solver settings by {loss.default_error.largest:.0%}, a "
        f"sheath's by {loss.sheath_error.largest:.2%}",
        soft_wrap=True,
    )


def _ratio(spread: Spread) -> str:
    return f"{spread.median:.2f} × ({_range(spread)})"


def _range(spread: Spread, scale: float = 1.0, form: str = ".2f") -> str:
    return f"{spread.low * scale:{form}} … {spread.high * scale:{form}}"
