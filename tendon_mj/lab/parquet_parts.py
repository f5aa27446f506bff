"""A table in a folder of Parquet files, one for each task, as pandas and pyarrow read it whole."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tendon_mj.errors import MissingPackageError
from tendon_mj.whole_file import whole_file

Column = NDArray[Any]
_PART = b"tendon_mj part"  # in a file's metadata: of which run and task it is


class ParquetParts:
    """Keeps the tables of tasks; the order of rows is that of the keys.

    A file of another run, or one that cannot be read, does not count: its task is done again. Files
    of something else are neither read nor removed.
    """

    def __init__(self, folder: Path, of: str = "", *, again: bool = False) -> None:
        try:
            import pyarrow
            import pyarrow.dataset
            import pyarrow.parquet
        except ImportError:
            raise MissingPackageError(
                f"{folder}: tables are written as Parquet through pyarrow, which is not installed;"
                " pip install 'tendon-mj[parquet]'"
            ) from None
        self._pyarrow: Any = pyarrow
        self._of = of
        self.folder = folder
        folder.mkdir(parents=True, exist_ok=True)
        files = [] if again else folder.glob("*.parquet")
        self._kept = {p.stem for p in files if self._part_of(p) == self._part(p.stem)}

    def done(self) -> set[str]:
        """Keys of the tasks whose table is there."""
        return set(self._kept)

    def write(self, key: str, result: Mapping[str, Column]) -> None:
        """Keep the table of a task: column → (rows,)."""
        table = self._pyarrow.table(dict(result), metadata={_PART: self._part(key)})
        with whole_file(self._path(key)) as made:
            self._pyarrow.parquet.write_table(table, made)
        self._kept.add(key)

    def read(self, columns: Sequence[str] | None = None) -> dict[str, Column]:
        """Column → (rows,) of all tasks; ``columns``: only these."""
        files = [str(self._path(key)) for key in sorted(self._kept)]
        if not files:
            return {}
        table = self._pyarrow.dataset.dataset(files).to_table(columns)
        return {name: np.asarray(table[name]) for name in table.column_names}

    def clear(self) -> None:
        """Remove the tables of every run, and those that a killed run left half written."""
        for path in self.folder.glob("*.parquet"):
            if path.name.startswith(".") or self._part_of(path):
                path.unlink()
        self._kept.clear()

    def _path(self, key: str) -> Path:
        return self.folder / f"{key}.parquet"

    def _part(self, key: str) -> bytes:
        return f"{self._of} {key}".encode()

    def _part_of(self, path: Path) -> bytes | None:
        """Run and task of a table, empty for a foreign one; None if it cannot be read."""
        try:
            metadata = self._pyarrow.parquet.read_metadata(path).metadata or {}
        except (self._pyarrow.ArrowException, OSError):
            return None
        return bytes(metadata.get(_PART, b""))
