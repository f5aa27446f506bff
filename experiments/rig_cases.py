"""Diagnoses of rigs of a suite, each in a folder of its own, and a line for each."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any

from tendon_mj.lab.diagnosis import Diagnosis, diagnose

Case = dict[str, Any]


def diagnose_case(
    description: Path, truth: Mapping[str, Any], found: Callable[[Diagnosis], Mapping[str, Any]]
) -> Case:
    """Diagnose train.csv, held against hold.csv, beside a description; write found.json.

    Args:
        description: of the recordings, which lie beside it.
        truth: what is hidden in the rig.
        found: numbers of a diagnosis, beside its verdict, effects and sentence.
    """
    folder, start = description.parent, time.perf_counter()
    diagnosis = diagnose([folder / "train.csv"], [folder / "hold.csv"], description=description)
    case = {
        **truth,
        "verdict": diagnosis.verdict,
        "effects": list(diagnosis.effects),
        **found(diagnosis),
        "sentence": diagnosis.sentence,
        "seconds": time.perf_counter() - start,
    }
    (folder / "found.json").write_text(json.dumps(case, indent=1), encoding="utf-8")
    return case


def print_cases(cases: Iterable[Case]) -> list[Case]:
    """Print a line for each case as it is diagnosed; return them."""
    done = []
    for case in cases:
        done.append(case)
        print(
            f"{case['folder']}: {case['hidden']} hidden; {case['verdict']}"
            f" {', '.join(case['effects'])}; {case['sentence']}",
            flush=True,
        )
    return done
