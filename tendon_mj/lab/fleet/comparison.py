"""Comparison of a rig with the fleet: which of its numbers are outliers.

Of a number x_r with standard error s_r on rig r, the fleet has the median m and, from the median
absolute deviation, a spread S that a few rigs do not widen. A rig differs where

    |x_r − m| > 5 √(S² + s_r²),

whichever recording of it is left out, so that one odd day is not a difference. Its misfit, the rms
residual of the calibrated model, differs where it is also twice the median.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import NamedTuple

import mujoco
import numpy as np
from scipy.stats import median_abs_deviation

from tendon_mj.lab.recordings import Recording
from tendon_mj.models import model_digest

FEWEST = 5  # rigs, for a spread between them
DIFFERENT = 5.0  # standard deviations
MISFIT = "misfit"  # in place of a parameter's name [noise]
_LARGER = 2.0  # times the median


class FleetSpread(NamedTuple):
    """A number on all rigs of a fleet: its median, and its spread between them [its unit]."""

    median: float
    between: float


class RigDifference(NamedTuple):
    """A number of a rig that is not consistent with the fleet [its unit], and how far [spreads]."""

    name: str
    value: float
    spread: FleetSpread
    significance: float


def spread_between(values: Mapping[str, float], errors: Mapping[str, float]) -> FleetSpread:
    """Median and spread of rig → value, in excess of their standard errors."""
    every = np.array(list(values.values()))
    deviation = float(median_abs_deviation(every, scale="normal"))
    noise = float(np.median([errors[rig] for rig in values]))
    return FleetSpread(float(np.median(every)), float(np.sqrt(max(deviation**2 - noise**2, 0.0))))


def rig_differences(
    name: str,
    values: Mapping[str, float],
    errors: Mapping[str, float],
    spread: FleetSpread,
    one_out: Mapping[str, Sequence[float]] = MappingProxyType({}),
) -> dict[str, RigDifference]:
    """Rig → its difference, of the rigs that differ; empty where there are fewer than five rigs.

    ``values, errors``: rig → value of the number and its standard error [its unit]; ``one_out``:
    rig → its value with each of its recordings left out, where there are several.
    """
    if len(values) < FEWEST:
        return {}
    outliers = {}
    for rig, value in values.items():
        expected = float(np.hypot(spread.between, errors[rig]))
        side = np.sign(value - spread.median)
        away = min(side * (x - spread.median) for x in [value, *one_out.get(rig, ())])
        if away > DIFFERENT * expected:
            ratio = away / expected if expected > 0.0 else np.inf
            outliers[rig] = RigDifference(name, value, spread, float(ratio))
    return outliers


def larger_misfits(
    misfits: Mapping[str, float],
    one_out: Mapping[str, Sequence[float]] = MappingProxyType({}),
) -> dict[str, RigDifference]:
    """Like `rig_differences`, of the misfit [noise]."""
    errors = dict.fromkeys(misfits, 0.0)
    spread = spread_between(misfits, errors)
    outliers = rig_differences(MISFIT, misfits, errors, spread, one_out)
    least = {rig: min([misfits[rig], *one_out.get(rig, ())]) for rig in outliers}
    return {rig: one for rig, one in outliers.items() if least[rig] > _LARGER * spread.median}


def kind(recording: Recording, model: mujoco.MjModel) -> dict[str, str]:
    """Everything that rigs need to have in common: part of the description → its content."""
    tables = {"[uncertain]": recording.uncertain, "[known]": recording.known}
    contents = {name: repr(sorted(t.items())) for name, t in tables.items()}
    return {"model": model_digest(model)} | contents


def unlike(kinds: Mapping[str, Mapping[str, str]]) -> dict[str, list[str]]:
    """Rig → the parts of its `kind` that differ from most rigs', of the rigs that have any."""
    parts = sorted({part for one in kinds.values() for part in one}, key=lambda p: p[0] == "[")
    usual = {p: Counter(one[p] for one in kinds.values()).most_common(1)[0][0] for p in parts}
    differing = {rig: [p for p in parts if one[p] != usual[p]] for rig, one in kinds.items()}
    return {rig: parts for rig, parts in differing.items() if parts}
