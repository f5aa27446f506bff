"""Verdicts of a suite as any tool writes them, each beside its key."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

from experiments.hidden_effects.scoring.judged_case import PREDICTION, JudgedCase
from tendon_mj.errors import TendonError, unknown

VERDICTS = ("named", "partly", "parameter", "nothing missing", "unknown", PREDICTION)


def judge(verdicts: Path, keys: Path) -> list[JudgedCase]:
    """Cases of a suite that have a verdict or an error, each with its key.

    Args:
        verdicts: folder with a folder per case, in which are result.json, run.json or both.
        keys: folder with keys.json.

    Raises:
        TendonError: no case of the suite has a verdict, or a result.json is not as README.md says.
    """
    cases = json.loads((keys / "keys.json").read_text(encoding="utf-8"))["cases"]
    judged = []
    for name, key in cases.items():
        about, result = (_read(verdicts / name / f"{part}.json") for part in ("run", "result"))
        if about is None and result is None:
            continue
        if result is not None:
            _check(result, verdicts / name / "result.json")
        failed = bool((about or {}).get("error"))
        seconds = (about or result or {}).get("seconds", math.nan)
        judged.append(JudgedCase(name, key, None if failed else result, float(seconds)))
    if not judged:
        raise TendonError(f"{verdicts}: no verdict on any of the {len(cases)} cases of {keys}")
    return judged


def _read(path: Path) -> dict[str, Any] | None:
    if not path.exists():
        return None
    content: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return content


def _check(result: dict[str, Any], path: Path) -> None:
    verdict = result.get("verdict")
    if verdict not in VERDICTS:
        raise TendonError(f"{path}: {unknown('verdict', str(verdict), VERDICTS)}")
    if verdict in ("named", "partly", "parameter") and not result.get("effects"):
        raise TendonError(f"{path}: the verdict is {verdict!r}, and 'effects' names nothing")
    for name, value in result.get("parameters", {}).items():
        lacking = {"value", "low", "high"} - value.keys()
        if lacking:
            raise TendonError(f"{path}: parameter {name!r} lacks {', '.join(sorted(lacking))}")
