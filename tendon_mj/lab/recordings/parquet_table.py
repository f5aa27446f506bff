"""The columns of a Parquet file, read through pyarrow (the extra `parquet`)."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from tendon_mj.errors import MissingPackageError, RecordingError
from tendon_mj.lab.recordings.table_checks import Cells, OpenTable
from tendon_mj.lab.recordings.text_file import LARGEST, check_file

_BYTES = 8  # of a number
_FIRST = 2  # row of the first values in a CSV of the same table
_PLACE = re.compile("[0-9]{1,9}")  # in a list


def open_parquet(path: Path) -> OpenTable:
    """The names of a Parquet file's columns, and how to read them.

    Dots lead into lists and structs: ``position.0``. Rows in messages are those that a CSV of the
    same table would have.

    Raises:
        RecordingError: no Parquet file, or one without a column.
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
        schema = file.schema_arrow
        names = list(schema.names)
    except (pa.ArrowException, OSError, ValueError) as error:  # ValueError: a name not in UTF-8
        raise RecordingError(f"{path}: not a Parquet file: {error}") from None
    if not names:
        raise RecordingError(f"{path}: holds no column")

    def read(wanted: Mapping[str, bool], clock: str) -> tuple[Cells, list[str]]:
        roots = list(dict.fromkeys(_root(schema, name) for name in wanted))
        try:
            count = _numbers(file, roots)
            if count * _BYTES > LARGEST:
                raise RecordingError(
                    f"{path}: {file.metadata.num_rows} rows of {len(roots)} columns are more than"
                    f" {LARGEST} bytes; split the recording"
                )
            cells, faults = Cells(), list[str]()
            whole = {root: file.read(columns=[root]).column(root) for root in roots}
        except (pa.ArrowException, OSError, ValueError) as error:
            if isinstance(error, RecordingError):
                raise
            raise RecordingError(f"{path}: not a Parquet file: {error}") from None
        for name, needed in wanted.items():
            root = _root(schema, name)
            try:
                cells[name] = _cells(_part(whole[root], name[len(root) + 1 :]), name == clock)
            except (pa.ArrowException, TypeError) as error:
                if needed:
                    faults.append(f"{path}, column {name!r}: {error}")
        return cells, faults

    def has(name: str) -> bool:
        return _type_of(schema, name) is not None

    kinds = ((name, schema.field(k).type) for k, name in enumerate(names))
    sample = {name: "1970-01-01" for name, kind in kinds if pa.types.is_timestamp(kind)}
    return OpenTable(names, has, _FIRST, read, sample)


def _root(schema: Any, name: str) -> str:
    """The column that a name with dots is a part of; the name itself where it is a column."""
    parts = name.split(".")
    roots = (".".join(parts[:k]) for k in range(len(parts), 0, -1))
    return next((root for root in roots if root in schema.names), "")


def _type_of(schema: Any, name: str) -> Any:
    """Type of a column or of a part of one; None where there is none."""
    import pyarrow as pa

    root = _root(schema, name)
    if not root:
        return None
    kind = schema.field(schema.names.index(root)).type
    for part in filter(None, name[len(root) + 1 :].split(".")):
        if _is_list(kind) and _PLACE.fullmatch(part):
            kind = kind.value_type
        elif pa.types.is_struct(kind) and kind.get_field_index(part) >= 0:
            kind = kind.field(part).type
        else:
            return None
    return kind


def _is_list(kind: Any) -> bool:
    import pyarrow as pa

    return bool(
        pa.types.is_list(kind) or pa.types.is_large_list(kind) or pa.types.is_fixed_size_list(kind)
    )


def _part(column: Any, rest: str) -> Any:
    """The elements of lists, and fields of structs, that the rest of a name leads to."""
    import pyarrow.compute as pc

    for part in filter(None, rest.split(".")):
        if _is_list(column.type):
            column = pc.list_element(column, int(part))
        else:
            column = pc.struct_field(column, part)
    return column


def _cells(column: Any, is_clock: bool) -> Any:
    """Numbers with NaN for null; of a clock also dates and texts, as they are."""
    import pyarrow as pa

    kind = column.type
    if pa.types.is_integer(kind) or pa.types.is_floating(kind):
        if is_clock and not column.null_count:
            return np.asarray(column.to_numpy())
        return np.asarray(column.to_numpy(), dtype=np.float64)
    if is_clock and (pa.types.is_timestamp(kind) or pa.types.is_duration(kind)):
        return np.asarray(column.to_numpy())
    if is_clock and (pa.types.is_string(kind) or pa.types.is_large_string(kind)):
        return np.array([np.nan if cell is None else cell for cell in column.to_pylist()], object)
    raise TypeError(f"holds {kind}; a column holds numbers")


def _numbers(file: Any, roots: list[str]) -> int:
    """Numbers in columns, those in lists and structs among them."""
    metadata = file.metadata
    paths = [metadata.schema.column(k).path.split(".") for k in range(metadata.num_columns)]
    leaves = [k for k, path in enumerate(paths) if any(_leads(root, path) for root in roots)]
    groups = [metadata.row_group(k) for k in range(metadata.num_row_groups)]
    return sum(group.column(k).num_values for group in groups for k in leaves)


def _leads(root: str, path: list[str]) -> bool:
    return path[: root.count(".") + 1] == root.split(".")
