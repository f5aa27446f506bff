"""The solvers that most steps do without, called by a symbol.

A compiled function contains the code of those that it calls, and theirs, and is optimised with it:
with these two that took a third of the time in which the plugins compile.
"""

from __future__ import annotations

from typing import Any

import numba
from numba import carray, from_dtype, types
from numba.core import config

from tendon_mj.compilation import by_symbol, compiled
from tendon_mj.sheath.records import GUIDE, SEGMENT
from tendon_mj.sheath.tension_by_sweep import sweep
from tendon_mj.sheath.tension_with_drag import balance_dragged

_SEGMENTS, _GUIDES = types.CPointer(from_dtype(SEGMENT)), types.CPointer(from_dtype(GUIDE))


@by_symbol("tendon_mj.lab.sweep", types.boolean(_SEGMENTS, _GUIDES, numba.intp, types.boolean))
def _sweep(segments: Any, guides: Any, count: int, given: bool) -> bool:
    return sweep(carray(segments, count + 1), carray(guides, count), given)


@by_symbol("tendon_mj.balance_dragged", types.boolean(_SEGMENTS, _GUIDES, numba.intp))
def _balance_dragged(segments: Any, guides: Any, count: int) -> bool:
    return balance_dragged(carray(segments, count + 1), carray(guides, count))


@compiled
def rare_sweep(segments: Any, guides: Any, given: bool) -> bool:
    """As `sweep`."""
    return _sweep(segments.ctypes, guides.ctypes, len(guides), given)


@compiled
def rare_balance_dragged(segments: Any, guides: Any) -> bool:
    """As `balance_dragged`."""
    return _balance_dragged(segments.ctypes, guides.ctypes, len(guides))


if config.DISABLE_JIT:  # Python has no symbols
    rare_sweep, rare_balance_dragged = sweep, balance_dragged
