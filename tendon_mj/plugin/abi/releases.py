"""Offsets in every release of MuJoCo that the library knows, for programs without Python.

`offsets.csv` has a row for each field that is used, and a column for each minor release.
`python -m tendon_mj.plugin.abi.releases` writes that of the MuJoCo that is running.
"""

from __future__ import annotations

import csv
from typing import Final

import mujoco

from tendon_mj.plugin.abi.layout import LAYOUT, SCENE, TABLE, read

ENTRIES: Final = (*LAYOUT.names, *SCENE.names)


def running() -> tuple[str, list[int]]:
    """Minor release of the MuJoCo that is running, and its offsets in the order of ``ENTRIES``."""
    release = ".".join(mujoco.__version__.split(".")[:2])
    return release, [*read(LAYOUT).values(), *read(SCENE).values()]


def known() -> dict[str, list[int]]:
    """Minor release → offsets in the order of ``ENTRIES``."""
    with TABLE.open(encoding="utf-8", newline="") as file:
        head, *rows = csv.reader(file)
    offsets = {row[0]: [int(number) for number in row[1:]] for row in rows}
    return {release: [offsets[entry][k] for entry in ENTRIES] for k, release in enumerate(head[1:])}


def write() -> None:
    """Write the column of the MuJoCo that is running."""
    releases = known() | dict([running()])
    names = sorted(releases, key=lambda name: [int(part) for part in name.split(".")])
    with TABLE.open("w", encoding="utf-8", newline="") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(["entry", *names])
        columns = [releases[name] for name in names]
        table.writerows([entry, *row] for entry, *row in zip(ENTRIES, *columns, strict=True))


if __name__ == "__main__":
    write()
