"""Range check of the parameters that a model is built from."""

from __future__ import annotations

from collections.abc import Collection, Mapping

import numpy as np

from tendon_mj.errors import InvalidValueError


def check_range(
    parameters: Mapping[str, float],
    *,
    may_be_0: Collection[str] = (),
    signed: Collection[str] = (),
    where: str = "",
) -> None:
    """Refuse parameters that are not finite, or not positive where they must be.

    Args:
        parameters: value by name.
        may_be_0: names of those that must be ≥ 0; the others must be > 0.
        signed: names of those that may have any finite value.
        where: begins the message.

    Raises:
        InvalidValueError: names the first such parameter, its value and its range.
    """
    for name, value in parameters.items():
        if name in signed:
            in_range, bound = True, ""
        elif name in may_be_0:
            in_range, bound = value >= 0.0, " and ≥ 0"
        else:
            in_range, bound = value > 0.0, " and > 0"
        if not (np.isfinite(value) and in_range):
            raise InvalidValueError(f"{where}{name} = {value} must be finite{bound}")
