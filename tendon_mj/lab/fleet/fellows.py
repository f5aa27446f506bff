"""A rig beside its fellows: which of its numbers is not as theirs are.

Of a number x_r with standard error s_r on rig r, the fleet has the median m and, from the median
absolute deviation, a spread S that no few rigs can widen. A rig differs where

    |x_r − m| > 5 √(S² + s_r²),

whichever recording of it is left out, so that one odd day is no difference. What the calibrated
model leaves of a rig, its misfit, differs where it is also twice the median.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
from scipy.stats import median_abs_deviation

FEWEST = 5  # rigs, for a spread between them
DIFFERENT = 5.0  # standard deviations
MISFIT = "misfit"  # in place of a parameter's name [noise]
_LARGER = 2.0  # times the median


@dataclass(frozen=True)
class Spread:
    """A number on all rigs of a fleet: its median, and its spread between them [its unit]."""

    median: float
    between: float


@dataclass(frozen=True)
class Difference:
    """A number of a rig that is not as its fellows' [its unit]; how much, in spreads [-]."""

    name: str
    value: float
    spread: Spread
    significance: float


def spread_between(values: Mapping[str, float], errors: Mapping[str, float]) -> Spread:
    """Median and spread of rig → value, beyond their standard errors."""
    found = np.array(list(values.values()))
    median = float(np.median(found))
    deviation = float(median_abs_deviation(found, scale="normal"))
    own = float(np.median([errors[rig] for rig in values]))
    return Spread(median, float(np.sqrt(max(deviation**2 - own**2, 0.0))))


def differences(
    name: str,
    values: Mapping[str, float],
    errors: Mapping[str, float],
    spread: Spread,
    one_out: Mapping[str, Sequence[float]] = MappingProxyType({}),
) -> dict[str, Difference]:
    """Rig → how it differs, of the rigs that do; none where there are too few to tell.

    Args:
        name: of the number.
        values, errors: rig → its value and standard error [its unit].
        spread: of the values.
        one_out: rig → its value with each of its recordings left out, where there are several.
    """
    if len(values) < FEWEST:
        return {}
    found = {}
    for rig, value in values.items():
        expected = float(np.hypot(spread.between, errors[rig]))
        away = _least_away(value, one_out.get(rig, ()), spread.median)
        if away > DIFFERENT * expected:
            ratio = away / expected if expected > 0.0 else np.inf
            found[rig] = Difference(name, value, spread, float(ratio))
    return found


def larger_misfits(
    misfits: Mapping[str, float],
    one_out: Mapping[str, Sequence[float]] = MappingProxyType({}),
) -> dict[str, Difference]:
    """Rig → how its misfit differs, of the rigs whose model leaves far more than their fellows'.

    Args:
        misfits: rig → its misfit [noise].
        one_out: rig → that with each of its recordings left out, where there are several.
    """
    errors = dict.fromkeys(misfits, 0.0)
    spread = spread_between(misfits, errors)
    found = differences(MISFIT, misfits, errors, spread, one_out)
    least = {rig: min([misfits[rig], *one_out.get(rig, ())]) for rig in found}
    return {rig: one for rig, one in found.items() if least[rig] > _LARGER * spread.median}


def _least_away(value: float, one_out: Sequence[float], median: float) -> float:
    """How far a value is from the median whichever recording is left out; 0 if it turns about."""
    side = np.sign(value - median)
    return max(0.0, float(min(side * (x - median) for x in [value, *one_out])))
