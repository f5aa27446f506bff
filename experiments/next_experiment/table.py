"""Tables of the results."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

Outcomes = Sequence[Mapping[str, Any]]

_HEADER = [
    *("hidden", "recorded", "ties", "recorded, expected difference [noise]"),
    *("suggested", "verdict", "settled", "random settled"),
]


def table(outcomes: Outcomes) -> str:
    """Markdown: the figures, and a row for each tie."""
    ties = [o for o in outcomes if o["tie"]]
    given = [o for o in ties if o["suggested"] is not None]
    random = [after for o in ties for after in o["random"]]
    random_given = [after for o in given for after in o["random"]]
    figures: list[list[object]] = [
        ["cases", len(outcomes)],
        ["… that tie, the hidden effect among what ties", len(ties)],
        ["… with an experiment within the bounds that decides", len(given)],
        ["settled by the suggested experiment, of these", _share([o["suggested"] for o in given])],
        ["settled by a random one, of these", _share(random_given)],
        ["settled by the suggested experiment, of all ties", _settled(ties)],
        ["settled by a random one, of all ties", _share(random)],
        ["seconds of the search, largest", f"{max((o['seconds'] for o in ties), default=0.0):.0f}"],
    ]
    rows = [_row(outcome) for outcome in ties]
    return f"{_markdown(['', 'figure'], figures)}\n{_markdown(_HEADER, rows)}"


def _row(outcome: Mapping[str, Any]) -> list[object]:
    case, after = outcome["case"], outcome["suggested"]
    least = min(outcome["differences"], key=lambda d: d["expected"], default=None)
    random = [after["settled"] for after in outcome["random"]]
    return [
        case["hidden"],
        f"{case['motion']}, {case['sensors']}",
        "; ".join(" or ".join(group) for group in outcome["ties"]),
        f"{least['recorded']:.2g}, {least['expected']:.2g}" if least else "",
        after["experiment"] if after else "none decides",
        f"{after['verdict']}: {', '.join(after['effects'])}" if after else "",
        ("yes" if after["settled"] else "no") if after else "",
        f"{sum(random)} of {len(random)}",
    ]


def _settled(ties: Outcomes) -> str:
    return _share([o["suggested"] or {"settled": False} for o in ties])


def _share(afters: Outcomes) -> str:
    if not afters:
        return "-"
    count = sum(after["settled"] for after in afters)
    return f"{count} of {len(afters)}, {count / len(afters):.0%}"


def _markdown(header: Sequence[str], rows: Sequence[Sequence[object]]) -> str:
    lines = [header, ["---"] * len(header), *rows]
    return "\n".join("| " + " | ".join(map(str, line)) + " |" for line in lines) + "\n"
