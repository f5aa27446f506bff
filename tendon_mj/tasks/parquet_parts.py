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


class ParquetParts:
    """Keeps the tables of tasks; the order of rows is that of the keys.

    Args:
        folder: made if it is not there.

    Raises:
        MissingPackageError: pyarrow is not installed.
    """

    def __init__(self, folder: Path) -> None:
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
        self.folder = folder
        folder.mkdir(parents=True, exist_ok=True)

    def done(self) -> set[str]:
        """Keys of the tasks whose table is there."""
        return {path.stem for path in self._files()}

    def write(self, key: str, result: Mapping[str, Column]) -> None:
        """Keep the table of a task: column → (rows,)."""
        with whole_file(self.folder / f"{key}.parquet") as made:
            self._pyarrow.parquet.write_table(self._pyarrow.table(dict(result)), made)

    def read(self, columns: Sequence[str] | None = None) -> dict[str, Column]:
        """Column → (rows,) of all tasks; ``columns``: only these."""
        files = [str(path) for path in self._files()]
        if not files:
            return {}
        table = self._pyarrow.dataset.dataset(files).to_table(columns)
        return {name: np.asarray(table[name]) for name in table.column_names}

    def clear(self) -> None:
        """Remove every table, and what a killed run left half written."""
        for path in self.folder.glob("*.parquet"):
            path.unlink()

    def _files(self) -> list[Path]:
        return sorted(p for p in self.folder.glob("*.parquet") if not p.name.startswith("."))
