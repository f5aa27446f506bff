"""Table of a fleet: a row for each rig."""

from __future__ import annotations

from pathlib import Path

import pandas

from tendon_mj.lab.fleet import FleetFound
from tendon_mj.whole_file import whole_file


def write_table(found: FleetFound, path: Path) -> Path:
    """Write a CSV with a row for each rig, in SI units, and return its path."""
    with whole_file(path) as made:
        pandas.DataFrame(found.table()).to_csv(made, index=False)
    return path
