"""Summary of the study in a few lines of text."""

from __future__ import annotations

import math
from collections.abc import Iterator

from experiments.measured_joint import asked
from experiments.measured_joint.prediction import Error
from experiments.measured_joint.recording import ANGLE, TENSIONS
from experiments.measured_joint.splits import BETWEEN, BEYOND, LEFT_OUT
from experiments.measured_joint.study import Study

_MU = "sheath_1.friction"


def summary(found: Study) -> Iterator[str]:
    """Yield the lines."""
    for split, limit in ((BETWEEN, asked.BETWEEN), (BEYOND, asked.BEYOND)):
        (diagnosed,) = found.diagnoses[split]
        diagnosis = diagnosed.found
        yield f"{split}: {diagnosis.verdict}, {diagnosis.effects or diagnosis.closest}"
        if _MU in diagnosis.parameters:
            value = diagnosis.parameters[_MU]
            low, high = asked.FRICTION
            yield (
                f"  μ = {value.value:.3f} ({value.low:.3f} … {value.high:.3f});"
                f" asked {low} … {high}"
            )
        for one in diagnosed.shown:
            before, after = one.errors
            yield (
                f"  {after.bend}°: {_words(before)} → {_words(after)}"
                f" (asked {math.degrees(limit):.1f}°)"
            )
    for diagnosed in found.diagnoses[LEFT_OUT]:
        diagnosis, (one,) = diagnosed.found, diagnosed.shown
        before, after = one.errors
        effects = ", ".join(diagnosis.effects or diagnosis.closest)
        yield f"all but {after.bend}°: {diagnosis.verdict}, {effects}"
        yield f"  {after.bend}°: {_words(before)} → {_words(after)}"
    own = {"diagnosis": {split: found.diagnosed_errors(split) for split in found.diagnoses}}
    for name, splits in {**own, **found.errors}.items():
        yield f"{name}: " + "; ".join(
            f"{split} {_mean(splits[split]):.2f}°" for split in (BETWEEN, BEYOND, LEFT_OUT)
        )


def _words(error: Error) -> str:
    tensions = ", ".join(f"{error.rms[column]:.2f}" for column in TENSIONS)
    return f"{math.degrees(error.rms[ANGLE]):.2f}° and {tensions} N"


def _mean(errors: list[Error]) -> float:
    """Mean angle error over bends and seeds [deg]."""
    return math.degrees(sum(one.rms[ANGLE] for one in errors) / len(errors))
