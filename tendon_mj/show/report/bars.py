"""Bars that the charts and the pictures of a report both draw: errors, and shares of the misfit."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from tendon_mj.lab.diagnosis import Located
from tendon_mj.lab.replay import column_name
from tendon_mj.show.figures.style import BLUE, GREY, PALE, PURPLE, VERMILLION

TIME_SPENT, BEFORE, SYSID, AFTER = "time spent there", "before", "mujoco.sysid alone", "after"
FLOOR = "noise and reproducibility"
LABEL_COLOURS = {TIME_SPENT: PALE, BEFORE: VERMILLION, SYSID: PURPLE, AFTER: BLUE, FLOOR: GREY}


class Regime(NamedTuple):
    """Names of the bins of a regime, and label → a length for each."""

    bins: list[str]
    series: dict[str, list[float]]


def error_bars(
    signal: tuple[float, float, float], sysid: float | None, *, changed: bool
) -> dict[str, float]:
    """Label → rms error of a signal, from those before and after and the noise [its unit]."""
    before, after, _ = signal
    bars = {BEFORE: before, SYSID: sysid, AFTER: after if changed else None}
    return {label: error for label, error in bars.items() if error is not None}


def misfit_bars(located: Located, remaining: Located | None) -> dict[str, Regime]:
    """Regime → share [%] of the misfit beyond noise in each of its bins, and that of the time.

    The excess is the power beyond noise, time × (rms² − 1); that after is in shares of the excess
    before.
    """
    whole = sum(_excess(b.time, b.rms) for b in located.bins if b.regime == "signal")
    unit = 100.0 / whole if whole > 0.0 else 0.0
    regimes = _regimes(located, TIME_SPENT, BEFORE, *([AFTER] if remaining else []))
    after = _rms(remaining) if remaining else {}
    for b in located.bins:
        series = regimes[b.regime].series
        series[TIME_SPENT].append(100.0 * b.time)
        series[BEFORE].append(unit * _excess(b.time, b.rms))
        if remaining:
            rms = after.get((b.regime, b.label), 1.0)
            series[AFTER].append(unit * _excess(b.time, rms))
    return regimes


def proof_bars(before: Located, after: Located) -> dict[str, Regime]:
    """Regime → rms error on held-out data in each of its bins, before and after [noise]."""
    regimes, rms = _regimes(before, BEFORE, AFTER), _rms(after)
    for b in before.bins:
        regimes[b.regime].series[BEFORE].append(b.rms)
        regimes[b.regime].series[AFTER].append(rms.get((b.regime, b.label), b.rms))
    return regimes


def noise_floor(floors: Mapping[str, float]) -> float:
    """Noise and reproducibility over all signals, from those of each column [noise]."""
    return float(np.sqrt(np.mean(np.square(list(floors.values())))))


def _regimes(located: Located, *labels: str) -> dict[str, Regime]:
    """Regimes with their bins, and empty series."""
    regimes: dict[str, Regime] = {}
    for b in located.bins:
        regime = regimes.setdefault(b.regime, Regime([], {label: [] for label in labels}))
        regime.bins.append(column_name(b.label) if b.regime == "signal" else b.label)
    return regimes


def _rms(located: Located) -> Mapping[tuple[str, str], float]:
    return {(b.regime, b.label): b.rms for b in located.bins}


def _excess(time: float, rms: float) -> float:
    return time * (rms**2 - 1.0)
