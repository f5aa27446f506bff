"""Scores the findings on a hidden fleet; `python -m experiments.fleet.score_fleet --help`."""

from __future__ import annotations

import json
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import Any

import tyro

ALIKE = {"sheath.friction": "sheath.drawn_bend"}  # of which the data determine the product only


@dataclass(frozen=True, kw_only=True)
class Settings:
    """Inputs of the comparison.

    Attributes:
        key: file of `make_fleet`.
        result: result.json of `tendon-mj fleet`.
        out: file for the score.
    """

    key: Path
    result: Path
    out: Path


def score(key: dict[str, Any], rigs: list[dict[str, Any]]) -> dict[str, Any]:
    """Count changes found, named and dated, and false alarms.

    Args:
        key: rig → its change.
        rigs: of result.json.
    """
    results = {rig["rig"]: rig for rig in rigs}
    rows = {name: _row(true, results[name]) for name, true in key.items()}
    return {
        "rigs": len(rigs),
        "changed": len(key),
        "found": sum(row["found"] for row in rows.values()),
        "named": sum(row.get("named", False) for row in rows.values()),
        "named_first": sum(row.get("named_first", False) for row in rows.values()),
        "within_a_recording": sum(
            abs(row["recordings_late"]) <= 1 for row in rows.values() if row["found"]
        ),
        "false_alarms": sorted(
            rig["rig"]
            for rig in rigs
            if rig["rig"] not in key and rig["verdict"] in ("changed", "differs")
        ),
        "failed": sorted(rig["rig"] for rig in rigs if rig["verdict"] == "failed"),
        "rows": rows,
    }


def _row(true: dict[str, Any], rig: dict[str, Any]) -> dict[str, Any]:
    """A change beside the one that was reported."""
    changed = rig["changed"]
    row = {"kind": true["kind"], "course": true["course"], "found": changed is not None}
    if changed is None:
        return row
    named = [changed["parameter"], *(rival["parameter"] for rival in changed["rivals"])]
    dates = [datetime.fromisoformat(date) for date in rig["dates"]]
    place = dates.index(datetime.fromisoformat(changed["since"]))
    return row | {
        "named_first": named[0] == true["parameter"],
        "named": true["parameter"] in named or ALIKE.get(true["parameter"]) in named,
        "as": named,
        "recordings_late": place - dates.index(datetime.fromisoformat(true["since"])),
        "true": [true["since"], true["size"]],
        "said": [changed["since"], changed["before"], changed["after"]],
    }


def main(settings: Settings) -> None:
    """Write and print the score."""
    key = json.loads(settings.key.read_text(encoding="utf-8"))
    result = json.loads(settings.result.read_text(encoding="utf-8"))
    text = json.dumps(score(key, result["rigs"]), indent=1)
    settings.out.write_text(text + "\n", encoding="utf-8")
    print(text)


if __name__ == "__main__":
    main(tyro.cli(Settings))
