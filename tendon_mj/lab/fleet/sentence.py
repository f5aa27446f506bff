"""What is said of a rig: the change of a number, its course and its dates."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import datetime
from itertools import pairwise

import numpy as np

from tendon_mj.lab.diagnosis import CATALOGUE
from tendon_mj.lab.fleet.rig import stamp
from tendon_mj.lab.fleet.series import Series
from tendon_mj.lab.fleet.since import Change
from tendon_mj.lab.replay import engineering_unit, plain

_GAP = 2.0  # times the usual time between two recordings, above which the day is not known


def change_sentence(
    change: Change, series: Series, rivals: Sequence[Series], dates: Sequence[datetime]
) -> str:
    """A change in words, with values and dates.

    Args:
        change: the course that was found.
        series: the number, day by day.
        rivals: what explains the recordings as well.
        dates: of the recordings.
    """
    text = f"{what(series)} {_course(change, series, dates)}"
    if change.apart is not None:
        text += f", {stamp(change.apart)} apart"
    if rivals:
        text += f", or as well {', or '.join(what(rival) for rival in rivals)}"
    return text


def what(series: Series) -> str:
    """A number in words: its parameter, and the effect that it is of."""
    if not series.number.identifier:
        return series.number.name
    return f"{series.number.name} ({CATALOGUE[series.number.identifier].name})"


def in_one_unit(values: Sequence[float], unit: str) -> list[str]:
    """Values in one unit, the last with its symbol."""
    chosen = engineering_unit(unit, values)
    symbol = f" {chosen.symbol}" if chosen.symbol and chosen.symbol != "°" else chosen.symbol
    numbers = [plain(value * chosen.factor) for value in values]
    return [*numbers[:-1], f"{numbers[-1]}{symbol}"]


def _course(change: Change, series: Series, dates: Sequence[datetime]) -> str:
    if change.course == "varying":
        ends = [float(series.values.min()), float(series.values.max())]
        low, high = in_one_unit(ends, series.unit)
        return f"varies from {low} to {high}, with no single change"
    if change.between is not None and change.until is not None:
        values = [change.after, change.before, change.between]
        after, before, between = in_one_unit(values, series.unit)
        during = f"from {stamp(change.since)} to {stamp(change.until)}"
        return f"{before} → {between} {during}, {after} since"
    before, after = in_one_unit([change.before, change.after], series.unit)
    growing = "growing " if change.course == "ramp" else ""
    return f"{before} → {after} {growing}{_beginning(change, dates)}"


def _beginning(change: Change, dates: Sequence[datetime]) -> str:
    """Since when; between which days, where far more time than usual lies between them."""
    usual = float(np.median([(b - a).total_seconds() for a, b in pairwise(dates)]))
    if (change.since - change.last_same).total_seconds() <= _GAP * usual:
        return f"since {stamp(change.since)}"
    begun = "since a day " if change.course == "ramp" else ""
    return f"{begun}between {stamp(change.last_same)} and {stamp(change.since)}"
