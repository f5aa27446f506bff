"""Figures of the kinds that have what reality has: sessions, remainders, numbers too high."""

from __future__ import annotations

from collections.abc import Sequence

from experiments.hidden_effects.scoring.judged_case import JudgedCase
from experiments.hidden_effects.scoring.rates import Row, of_kind, share


def reality(judged: Sequence[JudgedCase]) -> list[Row]:
    """Rows of the table; cases whose strength was not reached count in none."""
    sessions, remainders, too_high = (
        [j for j in of_kind(judged, kind) if j.key["reached"]]
        for kind in ("session", "remainder", "too_high")
    )
    effects = [j for j in (*sessions, *remainders) if j.hidden]
    return [
        share(
            "one effect, 5 × what remains: first (tie: half)", "≥ 90 %", effects, lambda j: j.leads
        ),
        share("… sessions", "", [j for j in sessions if j.hidden], lambda j: j.leads),
        share("… remainders", "", remainders, lambda j: j.leads),
        share(
            "sessions and remainders: something named that is not there",
            "≤ 3 %",
            [*sessions, *remainders],
            lambda j: bool(j.false_names),
        ),
        share(
            "… sessions with nothing hidden",
            "",
            [j for j in sessions if not j.hidden],
            lambda j: bool(j.false_names),
        ),
        share("remainders: verdict partly", "", remainders, lambda j: j.verdict == "partly"),
        share(
            "number too high: called wrong, that one alone, true value in its interval",
            "≥ 95 %",
            too_high,
            lambda j: j.right_number,
        ),
        share("… called a wrong parameter", "", too_high, lambda j: j.verdict == "parameter"),
    ]
