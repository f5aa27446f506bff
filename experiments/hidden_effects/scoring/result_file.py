"""result.json and run.json as any tool writes them; what is not as README.md says is refused."""

from __future__ import annotations

import json
import math
import reprlib
from pathlib import Path
from typing import Any, NamedTuple, NoReturn

from experiments.hidden_effects.scoring.judged_case import NAMING, PREDICTION
from tendon_mj.errors import InvalidValueError, UnknownNameError
from tendon_mj.lab.diagnosis import CATALOGUE

INTERVAL = ("value", "low", "high")  # of a parameter
VERDICTS = (*NAMING, "parameter", "nothing missing", "unknown", PREDICTION)


class Run(NamedTuple):
    """Content of run.json: duration [s], and what went wrong, empty where nothing did."""

    seconds: float | None
    error: str


def read_run(path: Path) -> Run | None:
    """Read run.json; None where there is none.

    Raises:
        InvalidValueError: it cannot be read, or a value is not as README.md says.
    """
    content = read_json(path)
    if content is None:
        return None
    error = content.get("error", "")
    if not isinstance(error, str):
        _refuse(f"{path}, error", "a text, empty unless the tool failed", error)
    return Run(_seconds(content, path), error)


def read_result(path: Path) -> dict[str, Any] | None:
    """Read result.json; None where there is none.

    Raises:
        InvalidValueError: it cannot be read, or a value is not as README.md says.
        UnknownNameError: a verdict or an effect that does not exist.
    """
    content = read_json(path)
    if content is None:
        return None
    verdict = content.get("verdict")
    if not isinstance(verdict, str):
        _refuse(f"{path}, verdict", f"one of {', '.join(map(repr, VERDICTS))}", verdict)
    if verdict not in VERDICTS:
        raise UnknownNameError("verdict", verdict, VERDICTS, where=str(path))
    names = _names(content.get("effects", []), f"{path}, effects")
    if verdict in (*NAMING, "parameter") and not names:
        raise InvalidValueError(
            f"{path}: the verdict is {verdict!r}, and 'effects' names nothing; where nothing can be"
            " named it is 'unknown'"
        )
    groups = content.get("indistinguishable", [])
    if not isinstance(groups, list):
        _refuse(f"{path}, indistinguishable", "a list of groups of identifiers", groups)
    for k, group in enumerate(groups):
        _names(group, f"{path}, indistinguishable[{k}]")
    _check_parameters(_table(content, "parameters", str(path)), f"{path}, parameters")
    _number(content, "confidence", str(path), high=1.0)
    held_out = _table(_table(content, "gap", str(path)), "held_out", f"{path}, gap")
    _number(held_out, "after", f"{path}, gap.held_out")
    _number(held_out, "reducible_closed", f"{path}, gap.held_out", low=-math.inf)
    _seconds(content, path)
    return content


def read_json(path: Path) -> dict[str, Any] | None:
    """The object in a JSON file, without what is null; None where there is no file.

    Raises:
        InvalidValueError: it is no JSON (NaN and Infinity are none), or no object.
    """
    try:
        content = json.loads(path.read_text(encoding="utf-8"), parse_constant=_no_number)
    except FileNotFoundError:
        return None
    except (ValueError, RecursionError) as error:
        raise InvalidValueError(
            f"{path} cannot be read as JSON ({error}); write it again"
        ) from error
    if not isinstance(content, dict):
        _refuse(str(path), 'an object, such as {"verdict": "unknown"}', content)
    return {key: value for key, value in content.items() if value is not None}


def _no_number(constant: str) -> NoReturn:
    raise ValueError(f"{constant} is no number; null is what is missing")


def _refuse(where: str, wanted: str, value: object) -> NoReturn:
    got = "nothing" if value is None else reprlib.repr(value)
    raise InvalidValueError(f"{where}: must be {wanted}, got {got}")


def _names(value: object, where: str) -> list[str]:
    """Identifiers of the catalogue in a list."""
    if not isinstance(value, list) or not all(isinstance(name, str) for name in value):
        _refuse(where, 'a list of identifiers, such as ["backlash"]', value)
    for name in value:
        if name not in CATALOGUE:
            raise UnknownNameError("effect", name, CATALOGUE, where=where)
    return value


def _table(parent: dict[str, Any], key: str, where: str) -> dict[str, Any]:
    """Object under a key; empty where it is missing or null."""
    value = parent.get(key)
    if value is None:
        return {}
    if not isinstance(value, dict):
        _refuse(f"{where}, {key}", "an object", value)
    return value


def _check_parameters(parameters: dict[str, Any], where: str) -> None:
    for name in parameters:
        found = _table(parameters, name, where)
        numbers = {key: _number(found, key, f"{where}, {name!r}", -math.inf) for key in INTERVAL}
        lacking = ", ".join(key for key, number in numbers.items() if number is None)
        if lacking:
            raise InvalidValueError(f"{where}, {name!r} lacks {lacking}")
        if found["low"] > found["high"]:
            _refuse(f"{where}, {name!r}, low", f"at most high = {found['high']!r}", found["low"])


def _number(
    parent: dict[str, Any], key: str, where: str, low: float = 0.0, high: float = math.inf
) -> float | None:
    """Number under a key; None where it is missing or null."""
    value = parent.get(key)
    if value is None:
        return None
    # abs, as an integer may be too large for a float
    number = isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < 1e300
    if not number or not low <= value <= high:
        bounds = [f"≥ {low:g}"] * (low > -math.inf) + [f"≤ {high:g}"] * (high < math.inf)
        _refuse(f"{where}, {key}", " and ".join(["a finite number", *bounds]), value)
    return float(value)


def _seconds(content: dict[str, Any], path: Path) -> float | None:
    return _number(content, "seconds", str(path))
