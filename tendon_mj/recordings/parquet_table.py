"""The numbers of a recording as Parquet, read through pyarrow (the extra `parquet`)."""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path

import numpy as np

from tendon_mj.errors import MissingPackageError, RecordingError
from tendon_mj.recordings.table_checks import FloatArray, check_table
from tendon_mj.recordings.text_file import LARGEST, check_file

_BYTES = 8  # of a number


def read_parquet(path: Path, elements: Collection[str] = ()) -> dict[str, FloatArray]:
    """Read a Parquet file into its columns in file order; each (n,) [the file's unit].

    Rows in messages are those that a CSV of the same table would have: the first values are row 2.

    Raises:
        RecordingError: no Parquet file, a column that is not of numbers, an empty cell, more
            numbers than a recording may have, or what `check_table` refuses.
        MissingPackageError: pyarrow is not installed.
    """
    check_file(path)
    try:
        import pyarrow as pa
        import pyarrow.parquet as pq
    except ImportError:
        raise MissingPackageError(
            f"{path}: Parquet is read through pyarrow, which is not installed;"
            " pip install 'tendon-mj[parquet]'"
        ) from None
    try:
        file = pq.ParquetFile(path)
        names, types = file.schema_arrow.names, file.schema_arrow.types
        cells = file.metadata.num_rows * file.metadata.num_columns
        for name, kind in zip(names, types, strict=True):
            if not (pa.types.is_integer(kind) or pa.types.is_floating(kind)):
                raise RecordingError(
                    f"{path}, column {name!r}: holds {kind}; a column holds numbers"
                )
        if cells * _BYTES > LARGEST:
            raise RecordingError(
                f"{path}: {file.metadata.num_rows} rows of {file.metadata.num_columns} columns are"
                f" more than {LARGEST} bytes; split the recording"
            )
        read = file.read()
    except RecordingError:
        raise
    except (pa.ArrowException, OSError, ValueError) as error:  # ValueError: a name not in UTF-8
        raise RecordingError(f"{path}: not a Parquet file: {error}") from None
    table = {}
    for name, column in zip(names, read.columns, strict=True):
        if column.null_count:
            row = np.flatnonzero(column.is_null().to_numpy())[0] + 2
            raise RecordingError(f"{path}, row {row}, column {name!r}: empty cell")
        if name in table:
            raise RecordingError(f"{path}, column {name!r}: the name of two columns")
        table[name] = np.asarray(column.to_numpy(), dtype=np.float64)
    if not table:
        raise RecordingError(f"{path}: holds no column")
    check_table(table, str(path), elements=elements)
    return table
