"""Compilation of functions to machine code by Numba: kept on disk, and rounding as written."""

from tendon_mj.compilation.cache import announced as announced
from tendon_mj.compilation.decorators import apart as apart
from tendon_mj.compilation.decorators import by_symbol as by_symbol
from tendon_mj.compilation.decorators import callback as callback
from tendon_mj.compilation.decorators import checked as checked
from tendon_mj.compilation.decorators import compiled as compiled
