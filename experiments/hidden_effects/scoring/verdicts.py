"""Verdicts of a suite as any tool writes them, each beside its key."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from experiments.hidden_effects.scoring.judged_case import JudgedCase
from experiments.hidden_effects.scoring.result_file import read_json, read_result, read_run
from tendon_mj.errors import InvalidValueError, TendonError


def judge(verdicts: Path, keys: Path) -> list[JudgedCase]:
    """Every case of a suite, with its key; one without a verdict or an error is `missing`.

    Args:
        verdicts: folder with a folder per case, in which are result.json, run.json or both.
        keys: folder with keys.json.

    Raises:
        TendonError: no case of the suite has a verdict, or a file is not as README.md says.
    """
    cases = _keys(keys / "keys.json")
    judged = [_case(name, key, verdicts / name) for name, key in cases.items()]
    if all(case.missing for case in judged):
        raise TendonError(f"{verdicts}: no verdict on any of the {len(cases)} cases of {keys}")
    return judged


def _case(name: str, key: Mapping[str, Any], folder: Path) -> JudgedCase:
    run = read_run(folder / "run.json")
    failed = run is not None and bool(run.error)
    result = None if failed else read_result(folder / "result.json")
    seconds = None if run is None else run.seconds
    if seconds is None and result is not None:
        seconds = result.get("seconds")
    return JudgedCase(name, key, result, seconds, missing=run is None and result is None)


def _keys(path: Path) -> dict[str, Any]:
    cases = (read_json(path) or {}).get("cases")
    if not isinstance(cases, dict) or not cases:
        raise InvalidValueError(
            f"{path} has no 'cases'; --keys is the folder of keys.json, as make writes it"
        )
    return cases
