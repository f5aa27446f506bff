"""Verdicts of a suite as any tool writes them, checked and compared with the keys."""

from __future__ import annotations

import json
import math
import reprlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple, NoReturn

from experiments.hidden_effects.references import ReferenceBench
from tendon_mj.errors import InvalidValueError, TendonError, UnknownNameError
from tendon_mj.lab.diagnosis import CATALOGUE

PREDICTION = "prediction only"  # verdict of a tool that names nothing
NAMING = ("named", "partly")  # verdicts that name effects
PARAMETERS = ("friction", "axial_stiffness", "pretension", "bend_angle", "moment_arm")
RIVALS = 2  # most that a name may have in a tie; with more, the verdict leaves too much open
INTERVAL = ("value", "low", "high")  # of a parameter
VERDICTS = (*NAMING, "parameter", "nothing missing", "undetermined", "unknown", PREDICTION)


@dataclass(frozen=True)
class JudgedCase:
    """Verdict and key of one case.

    Attributes:
        name: of the case.
        key: entry of the case in keys.json.
        result: content of result.json, of which README.md says what is read; None if the
            diagnosis failed.
        seconds: that the diagnosis took, as the tool states it [s]; None if it does not.
        missing: whether the tool wrote nothing at all about the case, which counts as failed.
    """

    name: str
    key: Mapping[str, Any]
    result: Mapping[str, Any] | None
    seconds: float | None
    missing: bool = False

    @property
    def kind(self) -> str:
        """Kind of the case, see `suite.case_plan`."""
        return str(self.key["kind"])

    @property
    def hidden(self) -> list[str]:
        """Names of the effects, parameters or disturbances that were hidden."""
        return list(self.key["hidden"])

    @property
    def verdict(self) -> str:
        """Verdict as in result.json, or "failed"."""
        return "failed" if self.result is None else str(self.result["verdict"])

    @property
    def effects(self) -> list[str]:
        """Effects that the verdict names as missing, without wrong parameters."""
        if self.result is None or self.verdict not in NAMING:
            return []
        return [e for e in self.result["effects"] if e not in PARAMETERS]

    @property
    def named(self) -> list[str]:
        """All that the verdict names, effects and wrong numbers, the most important first."""
        if self.result is None or self.verdict not in (*NAMING, "parameter"):
            return []
        return list(self.result["effects"])

    @property
    def ties(self) -> list[list[str]]:
        """Names of the verdict that have one or two rivals, each with these."""
        return [[n, *rivals] for n, rivals in self._rivals.items() if 0 < len(rivals) <= RIVALS]

    @property
    def _rivals(self) -> dict[str, list[str]]:
        """Name in the verdict → names that the data cannot distinguish from it."""
        groups = [] if self.result is None else self.result.get("indistinguishable") or []
        return {
            name: list(dict.fromkeys(r for g in groups if name in g for r in g if r != name))
            for name in self.named
        }

    def _tied(self, name: str) -> list[str]:
        """Names of the tie of a name, itself included; empty where it is in none."""
        return next((tie for tie in self.ties if tie[0] == name), [])

    @property
    def named_effect(self) -> bool:
        """Whether the verdict names at least one effect as missing."""
        return self.verdict in NAMING and bool(self.effects)

    @property
    def confident(self) -> bool:
        """Whether something is named, and the first name, be it a number, is in no tie."""
        return bool(self.named) and not self._tied(self.named[0])

    @property
    def contains(self) -> bool:
        """Whether the verdict mentions all that is hidden, be it in a tie, and little else.

        Little is at most three names for each that is hidden: itself and the rivals of a tie.
        """
        mentioned = {*self.named, *(name for tie in self.ties for name in tie)}
        most = (1 + RIVALS) * len(self.hidden)
        return set(self.hidden) <= mentioned and len(mentioned) <= most

    @property
    def hit(self) -> float:
        """1 if the one hidden effect comes first; ½ where it is one of "A or B"."""
        if len(self.hidden) != 1 or not self.named_effect:
            return 0.0
        first = self.effects[0]
        tied = self._tied(first)
        return 0.0 if self.hidden[0] not in (first, *tied) else 0.5 if tied else 1.0

    @property
    def false_names(self) -> list[str]:
        """Names that are neither hidden nor tied with a hidden one.

        The rivals of a name that has more of them than a tie may have count as named.
        """
        wide = [r for rivals in self._rivals.values() if len(rivals) > RIVALS for r in rivals]
        tied = {name for tie in self.ties if set(tie) & set(self.hidden) for name in tie}
        right = {*self.hidden, *(tied - set(wide))}
        return [name for name in dict.fromkeys([*self.named, *wide]) if name not in right]

    @property
    def extra(self) -> list[str]:
        """Like `false_names`, without numbers called wrong."""
        if not self.named_effect:
            return []
        return [name for name in self.false_names if name not in PARAMETERS]

    @property
    def leads(self) -> float:
        """Like `hit`, but 0 if a wrong number is named before the hidden effect."""
        return self.hit if self.named[:1] == self.effects[:1] else 0.0

    @property
    def first(self) -> bool:
        """Whether the first of several hidden effects comes first, before wrong numbers too."""
        return self.named_effect and self.named[:1] == self.hidden[:1]

    @property
    def column(self) -> str:
        """Column of the case in the confusion matrix."""
        if not self.named_effect:
            return self.verdict
        return "A or B" if self._tied(self.effects[0]) else self.effects[0]

    @property
    def closed(self) -> float | None:
        """Share of the reducible error that was removed on held-out recordings."""
        if self.result is None:
            return None
        share = self._held_out.get("reducible_closed")
        return None if share is None else float(share)

    @property
    def left(self) -> float | None:
        """Rms error on held-out recordings, over all signals in units of their noise [-]."""
        left = self._held_out.get("after")
        return None if left is None else float(left)

    @property
    def right_number(self) -> bool:
        """Whether the verdict calls the hidden number wrong, no other, and its interval holds."""
        if self.result is None or self.verdict != "parameter" or self.false_names:
            return False
        given, true = self._given, self.key["parameters"]
        return given.keys() == true.keys() and all(
            given[name]["low"] <= value <= given[name]["high"] for name, value in true.items()
        )

    @property
    def _given(self) -> dict[str, dict[str, float]]:
        """Parameters as found; a drawn bend as the extra bend that keys state in its place."""
        result = dict({} if self.result is None else self.result.get("parameters") or {})
        for name in [n for n in result if n.endswith(".drawn_bend")]:
            bend = result.pop(name)
            shifted = {k: bend[k] - ReferenceBench.bend for k in ("value", "low", "high")}
            result[name.replace(".drawn_bend", ".extra_bend")] = {**bend, **shifted}
        return result

    @property
    def _held_out(self) -> Mapping[str, Any]:
        gap = {} if self.result is None else self.result.get("gap") or {}
        return dict(gap.get("held_out") or {})

    def errors(self) -> list[tuple[str, float, bool]]:
        """(parameter, relative error [-], whether its interval covers the truth), for each."""
        given = self._given
        results = []
        for name, true in self.key["parameters"].items():
            if name in given:
                inert = 1.0 if name.endswith(("scale", "efficiency")) else 0.0
                got = given[name]
                error = abs(got["value"] - true) / abs(true - inert)
                results.append((name, error, got["low"] <= true <= got["high"]))
        return results


class Run(NamedTuple):
    """Content of run.json: duration [s], and the error or ""."""

    seconds: float | None
    error: str


def read_run(path: Path) -> Run | None:
    """Read run.json; None if there is none.

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
    """Read result.json; None if there is none.

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
    """The object in a JSON file, without null entries; None without a file.

    Raises:
        InvalidValueError: not JSON (nor are NaN and Infinity), or not an object.
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
    raise ValueError(f"{constant} is not a number; write null for a missing one")


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
        result = _table(parameters, name, where)
        numbers = {key: _number(result, key, f"{where}, {name!r}", -math.inf) for key in INTERVAL}
        lacking = ", ".join(key for key, number in numbers.items() if number is None)
        if lacking:
            raise InvalidValueError(f"{where}, {name!r} lacks {lacking}")
        if result["low"] > result["high"]:
            _refuse(f"{where}, {name!r}, low", f"at most high = {result['high']!r}", result["low"])


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
