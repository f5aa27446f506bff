"""Sizes of numbers: how large and how small one may be, so that its square can still be summed."""

from __future__ import annotations

from typing import Final

LARGEST: Final = 1e30
SMALLEST: Final = 1.0 / LARGEST  # of what is not 0


def excess(value: float) -> str:
    """What is wrong with a finite number that is too large, whatever its sign; or nothing."""
    if abs(value) <= LARGEST:
        return ""
    return f"{value:g} is no size that can be computed with, at most {LARGEST:g}"


def size_fault(value: float) -> str:
    """What is wrong with the size of a finite number, such as "1e+308 is no size …"; or nothing."""
    if value == 0.0 or SMALLEST <= abs(value) <= LARGEST:
        return ""
    return (
        f"{value:g} is no size that can be computed with; it must be 0, or from {SMALLEST:g} to"
        f" {LARGEST:g} whatever its sign"
    )
