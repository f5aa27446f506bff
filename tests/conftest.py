"""Stale machine code is thrown away before the package is imported.

Numba notices a changed function, but not a changed function that another one calls. The controller
of pytest-xdist does this once, before its workers start.
"""

import os
from pathlib import Path

PACKAGE = Path(__file__).parents[1] / "tendon_mj"


def drop_stale_cache() -> None:
    rooms = [PACKAGE / "sheath", PACKAGE / "engine"]
    sources = [p.stat().st_mtime for room in rooms for p in room.glob("*.py")]
    cached = [p for room in rooms for p in room.glob("__pycache__/*.nb[ic]")]
    if cached and max(sources) > min(p.stat().st_mtime for p in cached):
        for path in cached:
            path.unlink(missing_ok=True)


if "PYTEST_XDIST_WORKER" not in os.environ:
    drop_stale_cache()
