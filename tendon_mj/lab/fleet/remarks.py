"""What else is to be known of a rig: another model, an odd day, what is left out or left over."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from datetime import datetime
from pathlib import Path

import numpy as np

from tendon_mj.lab.data_check import timing_warnings
from tendon_mj.lab.fleet.rig import stamp
from tendon_mj.lab.recordings import Recording

_SHARE = 0.5  # of the square of all that is left, above which one recording is odd
_ABOVE = 2.0  # times the median of the rigs, above which what is left is told
_FEWEST = 3  # recordings, for one of them to be odd


def kind(recording: Recording, model: str) -> dict[str, str]:
    """What rigs have to have alike to be compared: part of the description → its content.

    Args:
        recording: the first of a rig.
        model: digest of its model.
    """
    tables = {"[uncertain]": recording.uncertain, "[known]": recording.known}
    return {"model": model} | {name: repr(sorted(t.items())) for name, t in tables.items()}


def unlike(kinds: Mapping[str, Mapping[str, str]]) -> dict[str, str]:
    """Rig → in what it is not as most rigs, of those that are not."""
    parts = sorted(
        {part for one in kinds.values() for part in one}, key=lambda part: part[0] == "["
    )
    usual = {p: Counter(one[p] for one in kinds.values()).most_common(1)[0][0] for p in parts}
    found = {
        rig: " and ".join(p for p in parts if one[p] != usual[p]) for rig, one in kinds.items()
    }
    return {
        rig: f"its {words} not as on most rigs, so that the comparison does not count"
        for rig, words in ((rig, _is_or_are(parts)) for rig, parts in found.items() if parts)
    }


def _is_or_are(parts: str) -> str:
    return f"{parts} {'are' if ' and ' in parts else 'is'}"


def odd_day(dates: Sequence[datetime], square: Sequence[float], usual: float) -> str:
    """The recording that most of what is left lies in; empty without one.

    Args:
        dates: of the recordings.
        square: mean square of what is left of each [noise²].
        usual: root mean square of what is left of the median rig [noise].
    """
    largest, whole = int(np.argmax(square)), float(np.sum(square))
    left = float(np.sqrt(square[largest]))
    if len(dates) < _FEWEST or square[largest] < _SHARE * whole or left < _ABOVE * usual:
        return ""
    return f"most of its misfit is on {stamp(dates[largest])}, {left:.2g} noise"


def left_out(tables: Mapping[datetime, Path], refused: Mapping[datetime, str]) -> list[str]:
    """Which recordings are left out and why, each by its file.

    Args:
        tables: date → file of each recording.
        refused: date → why it is left out.
    """
    return [
        f"{tables[date]} is left out: "
        + reason.removeprefix(str(tables[date])).lstrip(":, ").removesuffix(".")
        for date, reason in refused.items()
    ]


def odd_times(recordings: Iterable[Recording]) -> list[str]:
    """What is odd about the times of recordings: the first of each kind, and how many there are."""
    found: dict[str, list[str]] = {}
    for recording in recordings:
        for warning in timing_warnings(recording):
            found.setdefault(warning.identifier, []).append(warning.sentence)
    return [
        f"{told[0]}; so in {len(told)} recordings" if len(told) > 1 else told[0]
        for told in found.values()
    ]


def left_over(left: float, usual: float) -> str:
    """What a change leaves, where that is far more than usual [noise]; else empty."""
    return (
        f"{left:.2g} noise is left, so that more may have changed" if left > _ABOVE * usual else ""
    )
