"""Plain numbers of the study, for `result.json`: SI units, angles in radians, bends in degrees."""

from __future__ import annotations

from collections.abc import Mapping

from experiments.measured_joint import asked
from experiments.measured_joint.prediction import Error
from experiments.measured_joint.study import Diagnosed, Study


def result(found: Study) -> dict[str, object]:
    """Nested dictionary of numbers in SI units."""
    return {
        "asked": {
            "friction": list(asked.FRICTION),
            "between_rad": asked.BETWEEN,
            "beyond_rad": asked.BEYOND,
        },
        "diagnoses": {
            split: [_diagnosed(one) for one in each] for split, each in found.diagnoses.items()
        },
        "held_out": {
            name: {split: [_error(one) for one in errors] for split, errors in splits.items()}
            for name, splits in found.errors.items()
        },
    }


def _diagnosed(diagnosed: Diagnosed) -> Mapping[str, object]:
    errors = [one.errors for one in diagnosed.shown]
    return {
        "diagnosis": diagnosed.found.result(),
        "held_out": [{"before": _error(b), "after": _error(a)} for b, a in errors],
    }


def _error(one: Error) -> Mapping[str, object]:
    return {"bend_deg": one.bend, "seed": one.seed, **one.rms}
