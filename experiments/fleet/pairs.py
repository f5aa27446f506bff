"""Two recordings of each rig of a hidden fleet; `python -m experiments.fleet.pairs --help`.

Of a rig that changes, each of its recordings before that is held against each after it, and of a
rig that does not, each against each later one; a rig gives so many pairs at most, drawn at random.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from datetime import datetime
from itertools import combinations
from pathlib import Path

import numpy as np
import tyro

from experiments.fleet.score_fleet import ALIKE
from tendon_mj.lab.fleet import compare_states, find_rigs


@dataclass(frozen=True, kw_only=True)
class Settings:
    """A hidden fleet.

    Attributes:
        fleet: folder of `make_fleet`.
        key: its key.
        out: file for the score.
        pairs: of each rig, at most.
        seed: of the draw of pairs.
    """

    fleet: Path
    key: Path
    out: Path
    pairs: int = 5
    seed: int = 1


def main(settings: Settings) -> None:
    """Count pairs that are found changed, and those whose change is named."""
    key = json.loads(settings.key.read_text(encoding="utf-8"))
    rng = np.random.default_rng(settings.seed)
    rows = []
    for rig in find_rigs(settings.fleet):
        true, data = key.get(rig.name), rig.read()
        # a change that grows is whole on the last day only
        late = rig.dates[-1:] if true and true["course"] == "ramp" else rig.dates
        pairs = [
            (rig.dates.index(one), rig.dates.index(other))
            for one, other in combinations(rig.dates, 2)
            if true is None or (one < datetime.fromisoformat(true["since"]) <= other in late)
        ]
        for k in sorted(rng.permutation(len(pairs))[: settings.pairs]):
            old, new = ([r for r in [data.recordings[i]] if r] for i in pairs[k])
            found = compare_states(old, new, data.model)
            names = [one.parameter for one in (found.series, *found.rivals) if found.changed]
            wanted = true and true["parameter"]
            rows.append(
                {
                    "rig": rig.name,
                    "days": [rig.dates[i].isoformat() for i in pairs[k]],
                    "true": wanted,
                    "found": names,
                    "named": bool({wanted, ALIKE.get(wanted)} & set(names)),
                    "significance": found.significance,
                    "sentence": found.sentence,
                }
            )
            print(f"{rig.name}: {wanted}: {found.sentence}", flush=True)
    changed = [row for row in rows if row["true"]]
    score = {
        "changed": len(changed),
        "found": sum(bool(row["found"]) for row in changed),
        "named": sum(row["named"] for row in changed),
        "named_first": sum(row["found"][:1] == [row["true"]] for row in changed),
        "unchanged": len(rows) - len(changed),
        "false_alarms": sum(bool(row["found"]) for row in rows if not row["true"]),
        "rows": rows,
    }
    settings.out.write_text(json.dumps(score, indent=1), encoding="utf-8")
    print({name: value for name, value in score.items() if name != "rows"})


if __name__ == "__main__":
    main(tyro.cli(Settings))
