"""A verdict beside the key of its case: what is right about it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

PARAMETERS = ("friction", "axial_stiffness", "pretension", "bend_angle", "moment_arm")


@dataclass(frozen=True)
class Judged:
    """One case after its verdict; ``result`` is result.json, None where diagnosing failed."""

    name: str
    key: Mapping[str, Any]
    result: Mapping[str, Any] | None
    seconds: float

    @property
    def kind(self) -> str:
        """What sort of case it is."""
        return str(self.key["kind"])

    @property
    def hidden(self) -> list[str]:
        """What was hidden."""
        return list(self.key["hidden"])

    @property
    def verdict(self) -> str:
        """The word of the verdict."""
        return "failed" if self.result is None else str(self.result["verdict"])

    @property
    def effects(self) -> list[str]:
        """What it says is missing, wrong parameters left out."""
        if self.result is None or self.verdict == "parameter":
            return []
        return [e for e in self.result["effects"] if e not in PARAMETERS]

    @property
    def ties(self) -> list[list[str]]:
        """Groups of two or more that it says the data cannot tell apart."""
        groups = [] if self.result is None else self.result["indistinguishable"]
        return [list(g) for g in groups if len(g) > 1]

    @property
    def named_effect(self) -> bool:
        """Whether it says of some effect that it is missing, alone or among others."""
        return self.verdict == "named" and bool(self.effects)

    @property
    def confident(self) -> bool:
        """Whether the first effect named stands by itself."""
        return self.named_effect and not any(self.effects[0] in tie for tie in self.ties)

    @property
    def contains(self) -> bool:
        """Whether all that was hidden is somewhere in the verdict."""
        mentioned = {*self.effects, *(e for tie in self.ties for e in tie)}
        return self.verdict != "nothing missing" and set(self.hidden) <= mentioned

    @property
    def hit(self) -> float:
        """1 where the one hidden effect comes first; ½ where it is one of "A or B"."""
        if len(self.hidden) != 1 or not self.contains or self.verdict != "named":
            return 0.0
        tied = next((tie for tie in self.ties if self.hidden[0] in tie), [])
        first = bool(self.effects) and (
            self.effects[0] == self.hidden[0] or self.effects[0] in tied
        )
        return 0.0 if not first else 0.5 if tied else 1.0

    @property
    def extra(self) -> list[str]:
        """Effects named that are not hidden, and tie with nothing that is."""
        tied = {e for tie in self.ties if set(tie) & set(self.hidden) for e in tie}
        return [e for e in self.effects if e not in self.hidden and e not in tied]

    @property
    def column(self) -> str:
        """Where the case stands in the confusion matrix."""
        if not self.named_effect:
            return self.verdict
        return self.effects[0] if self.confident else "A or B"

    @property
    def closed(self) -> float | None:
        """Share of the reducible gap that is closed on held-out recordings."""
        if self.result is None:
            return None
        share = self.result["gap"]["held_out"].get("reducible_closed")
        return None if share is None else float(share)

    def errors(self) -> list[tuple[str, float, bool]]:
        """Parameter, its relative error, and whether its interval covers the truth."""
        given = {} if self.result is None else self.result["parameters"]
        found = []
        for name, true in self.key["parameters"].items():
            if name in given:
                inert = 1.0 if name.endswith("scale") else 0.0
                got = given[name]
                error = abs(got["value"] - true) / abs(true - inert)
                found.append((name, error, got["low"] <= true <= got["high"]))
        return found
