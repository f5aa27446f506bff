"""Tables of held-out errors in Markdown: the diagnosis beside every rival, signal by signal."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence

from experiments.measured_joint.candidates import CANDIDATES
from experiments.measured_joint.prediction import Error
from experiments.measured_joint.recording import ANGLE, TENSIONS
from experiments.measured_joint.splits import BETWEEN, BEYOND, LEFT_OUT
from experiments.measured_joint.study import Study

_ROWS = {0: "frictionless model, calibrated", 1: "**diagnosis**"}
_NUMBERS = {c.name: str(c.numbers or "–") for c in CANDIDATES}
_Cell = Callable[[Sequence[Error]], str]


def table(found: Study) -> str:
    """The whole page."""
    return "\n".join(
        [
            *_findings(found),
            "",
            *_errors(found, "angle, rms [deg]", _angle),
            "",
            *_errors(found, "tension 1 / tension 2, rms [N]", _tension),
            "",
        ]
    )


def _columns(found: Study) -> list[tuple[str, int]]:
    first = next(iter(found.errors.values()))
    return [
        (split, bend)
        for split in (BETWEEN, BEYOND, LEFT_OUT)
        for bend in sorted({one.bend for one in first[split]})
    ]


def _errors(found: Study, title: str, cell: _Cell) -> Iterator[str]:
    columns = _columns(found)
    heads = " | ".join(f"{split}: {bend}°" for split, bend in columns)
    yield f"| {title} | numbers | {heads} |"
    yield "|---" * (2 + len(columns)) + "|"
    for row, name in _ROWS.items():
        cells = []
        for split, bend in columns:
            made = found.diagnosed_errors(split, after=bool(row))
            cells.append(cell([one for one in made if one.bend == bend]))
        yield f"| {name} | – | {' | '.join(cells)} |"
    for name, errors in found.errors.items():
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


def _findings(found: Study) -> Iterator[str]:
    yield "| given | verdict | parameter | value | 95 % |"
    yield "|---|---|---|---|---|"
    told = [(split, one) for split, each in found.diagnoses.items() for one in each]
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
