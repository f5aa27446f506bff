"""Comparison of a verdict with the key of its case."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from experiments.hidden_effects.references.bench import ReferenceBench

PREDICTION = "prediction only"  # verdict of a tool that names nothing
NAMING = ("named", "partly")  # verdicts that name effects
PARAMETERS = ("friction", "axial_stiffness", "pretension", "bend_angle", "moment_arm")


@dataclass(frozen=True)
class JudgedCase:
    """Verdict and key of one case.

    Attributes:
        name: of the case.
        key: entry of the case in keys.json.
        result: content of result.json, of which README.md says what is read; None where the
            diagnosis failed.
        seconds: that the diagnosis took, as the tool states it [s]; None where it does not.
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
    def ties(self) -> list[list[str]]:
        """Groups of two or more effects that the data cannot tell apart, as the verdict says."""
        groups = [] if self.result is None else self.result.get("indistinguishable") or []
        return [list(g) for g in groups if len(g) > 1]

    @property
    def named_effect(self) -> bool:
        """Whether the verdict names at least one effect as missing."""
        return self.verdict in NAMING and bool(self.effects)

    @property
    def confident(self) -> bool:
        """Whether the first effect named is not part of a tie."""
        return self.named_effect and not any(self.effects[0] in tie for tie in self.ties)

    @property
    def contains(self) -> bool:
        """Whether the verdict mentions all hidden effects, be it in a tie."""
        mentioned = {*self.effects, *(e for tie in self.ties for e in tie)}
        return self.verdict != "nothing missing" and set(self.hidden) <= mentioned

    @property
    def hit(self) -> float:
        """1 where the one hidden effect comes first; ½ where it is one of "A or B"."""
        if len(self.hidden) != 1 or not self.contains or self.verdict not in NAMING:
            return 0.0
        tied = next((tie for tie in self.ties if self.hidden[0] in tie), [])
        first = bool(self.effects) and (
            self.effects[0] == self.hidden[0] or self.effects[0] in tied
        )
        return 0.0 if not first else 0.5 if tied else 1.0

    @property
    def extra(self) -> list[str]:
        """Effects named that are neither hidden nor tied with a hidden one."""
        tied = {e for tie in self.ties if set(tie) & set(self.hidden) for e in tie}
        return [e for e in self.effects if e not in self.hidden and e not in tied]

    @property
    def named(self) -> list[str]:
        """All that the verdict names, effects and wrong numbers, the most important first."""
        if self.result is None or self.verdict not in (*NAMING, "parameter"):
            return []
        return list(self.result["effects"])

    @property
    def leads(self) -> float:
        """Like `hit`, but 0 where a wrong number is named before the hidden effect."""
        return self.hit if self.named[:1] == self.effects[:1] else 0.0

    @property
    def false_names(self) -> list[str]:
        """Like `extra`, with numbers called wrong that are not."""
        tied = {e for tie in self.ties if set(tie) & set(self.hidden) for e in tie}
        return [e for e in self.named if e not in self.hidden and e not in tied]

    @property
    def column(self) -> str:
        """Column of the case in the confusion matrix."""
        if not self.named_effect:
            return self.verdict
        return self.effects[0] if self.confident else "A or B"

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
        if self.result is None or self.verdict != "parameter":
            return False
        given, true = self._given, self.key["parameters"]
        return given.keys() == true.keys() and all(
            given[name]["low"] <= value <= given[name]["high"] for name, value in true.items()
        )

    @property
    def _given(self) -> dict[str, dict[str, float]]:
        """Parameters as found; a drawn bend as the extra bend that keys state in its place."""
        found = dict({} if self.result is None else self.result.get("parameters") or {})
        for name in [n for n in found if n.endswith(".drawn_bend")]:
            bend = found.pop(name)
            shifted = {k: bend[k] - ReferenceBench.bend for k in ("value", "low", "high")}
            found[name.replace(".drawn_bend", ".extra_bend")] = {**bend, **shifted}
        return found

    @property
    def _held_out(self) -> Mapping[str, Any]:
        gap = {} if self.result is None else self.result.get("gap") or {}
        return dict(gap.get("held_out") or {})

    def errors(self) -> list[tuple[str, float, bool]]:
        """(parameter, relative error [-], whether its interval covers the truth), for each."""
        given = self._given
        found = []
        for name, true in self.key["parameters"].items():
            if name in given:
                inert = 1.0 if name.endswith("scale") else 0.0
                got = given[name]
                error = abs(got["value"] - true) / abs(true - inert)
                found.append((name, error, got["low"] <= true <= got["high"]))
        return found
