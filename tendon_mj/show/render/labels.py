"""Places for labels in a picture, so that none lies on another."""

from __future__ import annotations

from tendon_mj.typing import FloatArray


def free_spot(spot: FloatArray, taken: list[FloatArray], size: float) -> FloatArray:
    """The nearest place below ``spot`` that is clear of other labels; it is taken from then on.

    Args:
        spot: column and row [pixels].
        taken: places of other labels; one is added.
        size: of the text [pixels].
    """
    found = spot.copy()
    while any(_overlap(found - other, size) for other in taken):
        found[1] += 0.3 * size
    taken.append(found.copy())
    return found


def _overlap(apart: FloatArray, size: float) -> bool:
    """Whether two labels of a few letters would overlap, that far apart [pixels]."""
    return bool(abs(apart[1]) < 1.25 * size and abs(apart[0]) < 5.0 * size)
