"""Summary of the study in a few lines of text."""

from __future__ import annotations

from collections.abc import Iterator

from experiments.positioning_system import published
from experiments.positioning_system.descriptions import NAMES
from experiments.positioning_system.study import Study
from experiments.positioning_system.table import NUMBERS, offset


def summary(found: Study) -> Iterator[str]:
    """Yield the lines."""
    for name, one in found.described.items():
        diagnosis = one.diagnosis
        numbers = ", ".join(
            f"{what} {diagnosis.model[parameter]:.4g} {unit} (published {told:g})"
            for parameter, (what, unit, told) in NUMBERS.items()
        )
        worst = max(
            one.errors["after"][c] / one.errors["published"][c] for c in one.errors["after"]
        )
        yield (
            f"{NAMES[name]}: {diagnosis.verdict}, {', '.join(diagnosis.effects)}; {numbers}, offset"
            f" {offset(diagnosis.model):.2f} N ({published.OFFSET:g}); held-out error {worst:.2f}"
            f" times the published model's (asked {published.ERROR_RATIO:g})"
        )
