"""`tendon-mj rehearse`: diagnosis of a rig's own motions, simulated with a known effect."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from tendon_mj.cli.diagnose import diagnose, read_one
from tendon_mj.cli.options import Recordings, Repeated, flat, given_files
from tendon_mj.cli.output import Output, console
from tendon_mj.cli.recordings import parse_change
from tendon_mj.lab.diagnosis import CATALOGUE
from tendon_mj.lab.diagnosis import rehearse as simulate
from tendon_mj.lab.recordings import write_recording
from tendon_mj.lab.replay import Simulator
from tendon_mj.lab.units import quantity


def rehearse(
    recordings: Recordings,
    out: Path = Path("out/rehearse"),
    effect: Repeated[str] = (),
    hold_out: Repeated[Path] = (),
    description: Path | None = None,
    model: str | None = None,
    seed: int = 0,
) -> dict[str, object]:
    """Simulate your rig with an effect of known size, and diagnose it: what would be found?

    Args:
        recordings: Tables of the rig's motions. Only the driven columns count: what was measured is
            replaced, and may be zeros if nothing was measured yet.
        out: Folder for the diagnosis, as of `tendon-mj diagnose`, and the simulated recordings.
        effect: Effects of the catalogue by their identifiers, or parameters, with their values in
            SI units. Without any, the rig is as described, and nothing is to be found.
        hold_out: Motions that only test the result.
        description: TOML file that describes the columns of all recordings, with their noise.
        model: Model in place of the recordings' own: a name or an MJCF file.
        seed: Seed of the noise.

    Example:
        tendon-mj rehearse pull.csv --effect backlash=0.5e-3
    """
    paths = (*recordings, *flat(hold_out))
    given = given_files(paths, description, [model])
    output = Output(out / "recordings", writes=("*.csv", "*.toml"), given=given)
    read = [read_one(path, description, model, None) for path in paths]
    parameters = Simulator(read).parameters
    effects: dict[str, float] = {}
    for text in flat(effect):
        effects |= parse_change(text, {*CATALOGUE, *parameters}, "--effect")
    made, planted = simulate(read, effects, seed)
    tables = [
        output.add(write_recording(one, output.folder / f"{k}_{one.name}.csv"))
        for k, one in enumerate(made)
    ]
    output.close()
    train, held_out = tables[: len(recordings)], tables[len(recordings) :]
    result = diagnose(tuple(train), out, hold_out=(tuple(held_out),), sysid=False)
    for name, value in planted.items():
        true = quantity(value, parameters[name].unit)
        console.print(f"Planted {name} = {true}: {_found(name, parameters[name].unit, result)}.")
    return result


def _found(name: str, unit: str, result: Mapping[str, Any]) -> str:
    """The value of a planted parameter in the result of a diagnosis, in words."""
    value = {**result["calibrated"], **(result["parameters"] if result["effects"] else {})}
    if name not in value:
        return f"not found, the verdict is {result['verdict']}"
    number, low, high = (quantity(value[name][key], unit) for key in ("value", "low", "high"))
    return f"found {number}, 95 % within {low} … {high}"
