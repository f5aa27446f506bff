"""Report of the study: result.json, summary and table."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence

from experiments.measured_joint.candidates import CANDIDATES
from experiments.measured_joint.prediction import Error
from experiments.measured_joint.recording import ANGLE, TENSIONS
from experiments.measured_joint.splits import BETWEEN, BEYOND, LEFT_OUT
from experiments.measured_joint.study import Diagnosed, Study

_MU = "sheath_1.friction"
_ROWS = {0: "frictionless model, calibrated", 1: "**diagnosis**"}
_NUMBERS = {c.name: str(c.numbers or "–") for c in CANDIDATES}
_Cell = Callable[[Sequence[Error]], str]
FRICTION = (0.18, 0.25)  # μ [-]
BETWEEN_LIMIT = math.radians(2.3)  # angle error on each bend between the given ones, rms [rad]
BEYOND_LIMIT = math.radians(3.3)  # on each bend beyond them [rad]
EFFECT = "sheath_friction"  # to be named first


def result(study: Study) -> dict[str, object]:
    """Nested dictionary of numbers in SI units."""
    return {
        "asked": {
            "friction": list(FRICTION),
            "between_rad": BETWEEN_LIMIT,
            "beyond_rad": BEYOND_LIMIT,
        },
        "diagnoses": {
            split: [_diagnosed(one) for one in each] for split, each in study.diagnoses.items()
        },
        "held_out": {
            name: {split: [_error(one) for one in errors] for split, errors in splits.items()}
            for name, splits in study.errors.items()
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


def summary(study: Study) -> Iterator[str]:
    """Yield the lines."""
    for split, limit in ((BETWEEN, BETWEEN_LIMIT), (BEYOND, BEYOND_LIMIT)):
        (diagnosed,) = study.diagnoses[split]
        diagnosis = diagnosed.found
        yield f"{split}: {diagnosis.verdict}, {diagnosis.effects or diagnosis.closest}"
        if _MU in diagnosis.parameters:
            value = diagnosis.parameters[_MU]
            low, high = FRICTION
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
    for diagnosed in study.diagnoses[LEFT_OUT]:
        diagnosis, (one,) = diagnosed.found, diagnosed.shown
        before, after = one.errors
        effects = ", ".join(diagnosis.effects or diagnosis.closest)
        yield f"all but {after.bend}°: {diagnosis.verdict}, {effects}"
        yield f"  {after.bend}°: {_words(before)} → {_words(after)}"
    own = {"diagnosis": {split: study.diagnosed_errors(split) for split in study.diagnoses}}
    for name, splits in {**own, **study.errors}.items():
        yield f"{name}: " + "; ".join(
            f"{split} {_mean(splits[split]):.2f}°" for split in (BETWEEN, BEYOND, LEFT_OUT)
        )


def _words(error: Error) -> str:
    tensions = ", ".join(f"{error.rms[column]:.2f}" for column in TENSIONS)
    return f"{math.degrees(error.rms[ANGLE]):.2f}° and {tensions} N"


def _mean(errors: list[Error]) -> float:
    """Mean angle error over bends and seeds [deg]."""
    return math.degrees(sum(one.rms[ANGLE] for one in errors) / len(errors))


def table(study: Study) -> str:
    """The whole page."""
    return "\n".join(
        [
            *_findings(study),
            "",
            *_errors(study, "angle, rms [deg]", _angle),
            "",
            *_errors(study, "tension 1 / tension 2, rms [N]", _tension),
            "",
        ]
    )


def _columns(study: Study) -> list[tuple[str, int]]:
    first = next(iter(study.errors.values()))
    return [
        (split, bend)
        for split in (BETWEEN, BEYOND, LEFT_OUT)
        for bend in sorted({one.bend for one in first[split]})
    ]


def _errors(study: Study, title: str, cell: _Cell) -> Iterator[str]:
    columns = _columns(study)
    heads = " | ".join(f"{split}: {bend}°" for split, bend in columns)
    yield f"| {title} | numbers | {heads} |"
    yield "|---" * (2 + len(columns)) + "|"
    for row, name in _ROWS.items():
        cells = []
        for split, bend in columns:
            made = study.diagnosed_errors(split, after=bool(row))
            cells.append(cell([one for one in made if one.bend == bend]))
        yield f"| {name} | – | {' | '.join(cells)} |"
    for name, errors in study.errors.items():
        cells = [cell([e for e in errors[split] if e.bend == bend]) for split, bend in columns]
        yield f"| {name} | {_NUMBERS.get(name, '–')} | {' | '.join(cells)} |"


def _angle(errors: Sequence[Error]) -> str:
    return _range([math.degrees(one.rms[ANGLE]) for one in errors])


def _tension(errors: Sequence[Error]) -> str:
    return " / ".join(_range([one.rms[column] for one in errors]) for column in TENSIONS)


def _range(values: Sequence[float]) -> str:
    """Smallest and largest over the seeds, where they differ."""
    low, high = f"{min(values):.2f}", f"{max(values):.2f}"
    return low if low == high else f"{low}…{high}"


def _findings(study: Study) -> Iterator[str]:
    yield "| given | verdict | parameter | value | 95 % |"
    yield "|---|---|---|---|---|"
    told = [(split, one) for split, each in study.diagnoses.items() for one in each]
    for split, diagnosed in told:
        diagnosis = diagnosed.found
        if split == LEFT_OUT:
            split = f"all but {diagnosed.shown[0].measured.name}"
        effects = ", ".join(diagnosis.effects or diagnosis.closest)
        for name, value in {**diagnosis.parameters, **diagnosis.calibrated}.items():
            new = "" if name in diagnosis.calibrated else "**"
            yield (
                f"| {split} | {diagnosis.verdict}: {effects} | {new}`{name}`{new}"
                f" | {value.value:.4g}{value.suffix} | {value.low:.4g} … {value.high:.4g} |"
            )
