"""Ranges of randomisation from a diagnosis."""

from __future__ import annotations

import json
from pathlib import Path

from tendon_mj.errors import InvalidValueError


def ranges(result: str | Path, *, undetermined: bool = False) -> dict[str, tuple[float, float]]:
    """Ranges in which to draw parameters, from the 95 % intervals of a diagnosis.

    Names are those of `Parameters`: ``<sheath>.<parameter>``, and others of joints, sensors and
    drives, as the diagnosis fitted them. A number that was set anew for each recording ranges over
    its values there; one of a single recording, as a slip, is left out.

    Args:
        result: `result.json`, as `tendon-mj diagnose` writes it.
        undetermined: take a number that the data do not determine over its whole range, as the
            recordings or the catalogue state it.

    Returns:
        Name → (low, high), in SI units.

    Raises:
        InvalidValueError: a file of another command; a diagnosis that proves nothing; numbers that
            the data do not determine, unless ``undetermined``.
    """
    diagnosis = json.loads(Path(result).read_text(encoding="utf-8"))
    if "calibrated" not in diagnosis:
        raise InvalidValueError(
            f"{result} is not the result of a diagnosis; give result.json of `tendon-mj diagnose`"
        )
    if not diagnosis["proven"]:
        raise InvalidValueError(
            f"{result}: the verdict is {diagnosis['verdict']!r}, so that no number in it is proven;"
            " find what is missing first, or state ranges of your own"
        )
    values = {
        name: value
        for name, value in {**diagnosis["calibrated"], **diagnosis["parameters"]}.items()
        if " @ " not in name
    }
    loose = [name for name, value in values.items() if not value["determined"]]
    if loose and not undetermined:
        told = ", ".join(
            f"{name} ({values[name]['low']:g} … {values[name]['high']:g} {values[name]['unit']})"
            for name in loose
        )
        raise InvalidValueError(
            f"{result}: the data do not determine {told}; record what does, or take these whole"
            " ranges with undetermined=True"
        )
    return {name: (value["low"], value["high"]) for name, value in values.items()} | {
        name: (min(spread["values"].values()), max(spread["values"].values()))
        for name, spread in diagnosis["sessions"].items()
    }
