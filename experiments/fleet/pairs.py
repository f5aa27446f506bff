"""Two states of a rig, changed or not in between; `python -m experiments.fleet.pairs --help`.

Every pair is a rig and a motion of its own, recorded once in each state. Rigs and days differ as
those of `make_fleet`, and kinds of change are taken in turn.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from experiments.command import run_experiment, write_study
from experiments.fleet.changing_rig import KINDS, RigChange
from experiments.fleet.make_fleet import Plan, draw_drive, record
from experiments.fleet.score_fleet import ALIKE
from tendon_mj import load_model
from tendon_mj.cli import Output
from tendon_mj.lab.fleet import compare_states


@dataclass(frozen=True)
class Pair:
    """Result of a comparison.

    Attributes:
        seed: of the rig.
        kind: of its change; empty if it did not change.
        size: of the change.
        true: parameter that changed; empty if none did.
        found: parameters that explain the recordings, the first one named; none without a change.
        significance: of what explains most [standard errors].
        sentence: of the result.
    """

    seed: int
    kind: str
    size: float
    true: str
    found: Sequence[str]
    significance: float
    sentence: str

    @property
    def named(self) -> bool:
        """True if what changed is among the parameters found."""
        return bool({self.true, ALIKE.get(self.true)} & {*self.found})


def compare(seed: int, *, changes: bool) -> Pair:
    """Compare the two states of a rig."""
    random = np.random.default_rng([seed, changes])
    kind = [*KINDS][seed % len(KINDS)] if changes else ""
    size = float(random.uniform(*KINDS[kind].sizes)) if kind else 0.0
    change = RigChange(kind, size, "step", 1) if kind else None
    plan = Plan((seed, int(changes)), (0, 1), change, draw_drive(random))
    old, new = record(plan)
    result = compare_states([old], [new], load_model(old.model))
    found = [one.parameter for one in (result.series, *result.rivals) if result.changed]
    true = KINDS[kind].parameter if kind else ""
    return Pair(seed, kind, size, true, found, result.significance, result.sentence)


def compare_pairs(pairs: int = 100, first: int = 1, out: Path = Path("out/pairs")) -> None:
    """Compare the two states of rigs that changed, and of as many that did not.

    Args:
        pairs: rigs of each.
        first: seed of the first of them.
        out: folder for result.json and the table.
    """
    output, made = Output(out), list[Pair]()
    for seed in range(first, first + pairs):
        for changes in (True, False):
            made.append(pair := compare(seed, changes=changes))
            print(f"{seed} {pair.kind or 'none'}: {pair.sentence}", flush=True)
    rows = [vars(pair) | {"named": pair.named} for pair in made]
    write_study(output, [], {"pairs": rows}, table(made), summary(made))


def table(pairs: Sequence[Pair]) -> str:
    """Table in Markdown: kind of change, and how many are found and named."""
    rows = ["| change | pairs | found | named | named first |", "|---|---|---|---|---|"]
    for kind in sorted({pair.kind for pair in pairs}):
        own = [pair for pair in pairs if pair.kind == kind]
        counts = (sum(bool(p.found) for p in own), sum(p.named for p in own))
        first = sum(pair.found[:1] == [pair.true] for pair in own)
        cells = (kind or "none", len(own), *counts, first)
        rows.append("| " + " | ".join(map(str, cells)) + " |")
    return "\n".join(rows) + "\n"


def summary(pairs: Sequence[Pair]) -> list[str]:
    """The figures that count, a line each, and each pair that is wrong."""
    changed = [pair for pair in pairs if pair.kind]
    alarms = [pair for pair in pairs if not pair.kind and pair.found]
    named = [pair for pair in changed if pair.named]
    return [
        f"{len(named)} of {len(changed)} changes named,"
        f" {sum(bool(pair.found) for pair in changed)} found",
        f"{len(alarms)} of {len(pairs) - len(changed)} rigs without a change called changed",
        *(f"{p.seed} {p.kind or 'none'}: {p.sentence}" for p in changed + alarms if not p.named),
    ]


if __name__ == "__main__":
    sys.exit(run_experiment(compare_pairs, "fleet.pairs"))
