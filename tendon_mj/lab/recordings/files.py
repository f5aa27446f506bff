"""Files of a recording: where they are, their formats, and text with errors that say where."""

from __future__ import annotations

import tomllib
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from tendon_mj.errors import RecordingError, suggestion

FORMATS = (".csv", ".parquet", ".mcap")  # in the order in which a stem is sought
_AS_CSV = (".txt", ".tsv", ".dat", ".log")  # read as CSV where a path names them
_PANDAS = 'in Python: import pandas; pandas.{read}.to_csv("{stem}.csv", index=False)'
_OTHERS = {  # suffix → format, and how to convert it
    ".mat": (
        "a MATLAB file",
        'in MATLAB: writetable(table(time_s, …), "{stem}.csv"); in Python: import pandas, scipy.io;'
        ' log = scipy.io.loadmat("{name}"); pandas.DataFrame({{k: log[k].ravel() for k in'
        ' ["time_s", …]}}).to_csv("{stem}.csv", index=False)',
    ),
    ".h5": (
        "an HDF5 file",
        'in Python: import h5py, pandas; log = h5py.File("{name}"); pandas.DataFrame({{k: log[k][:]'
        ' for k in ["time_s", …]}}).to_csv("{stem}.csv", index=False)',
    ),
    ".db3": (
        "an SQLite file, as of rosbag2",
        "open its folder in PlotJuggler and save the topics as CSV; or, for each topic, ros2 topic"
        " echo --csv /topic > {stem}.csv while ros2 bag play plays it",
    ),
    ".bag": (
        "a bag of ROS 1",
        "rostopic echo -b {name} -p /topic > {stem}.csv; or save the topics as CSV in PlotJuggler",
    ),
    ".npz": (
        "an archive of NumPy",
        'in Python: import numpy, pandas; pandas.DataFrame(dict(numpy.load("{name}"))).to_csv('
        '"{stem}.csv", index=False)',
    ),
    ".npy": (
        "an array of NumPy",
        'in Python: import numpy; numpy.savetxt("{stem}.csv", numpy.load("{name}"), delimiter=",",'
        ' header="time_s,…", comments="")',
    ),
    ".pkl": (
        "a pickle, which can run any program and is never opened here",
        'in the program that wrote it: frame.to_parquet("{stem}.parquet")',
    ),
    ".xlsx": ("a workbook", "save its sheet as CSV"),
    ".feather": ("a Feather file", _PANDAS.replace("{read}", 'read_feather("{name}")')),
    ".json": ("JSON", _PANDAS.replace("{read}", 'read_json("{name}")')),
    ".jsonl": ("JSON lines", _PANDAS.replace("{read}", 'read_json("{name}", lines=True)')),
    ".tdms": (
        "a file of LabVIEW",
        'in Python: from nptdms import TdmsFile; TdmsFile.read("{name}").as_dataframe().to_csv('
        '"{stem}.csv", index=False)',
    ),
    ".ulg": ("a log of PX4", "pip install pyulog; ulog2csv {name}, which writes a CSV per topic"),
    ".mf4": (
        "a measurement file (MDF)",
        'in Python: from asammdf import MDF; MDF("{name}").to_dataframe().to_csv("{stem}.csv")',
    ),
    ".c3d": (
        "motion capture (C3D)",
        'in Python: import ezc3d, pandas; log = ezc3d.c3d("{name}"); pandas.DataFrame('
        'log["data"]["analogs"][0].T, columns=log["parameters"]["ANALOG"]["LABELS"]["value"])'
        '.to_csv("{stem}.csv"), of which the first column is time × log["header"]["analogs"]'
        '["frame_rate"]',
    ),
    ".sto": (
        "a file of OpenSim",
        'in Python: from pathlib import Path; Path("{stem}.csv").write_text(Path("{name}")'
        '.read_text().split("endheader")[1].lstrip())',
    ),
    ".gz": ("compressed", "gunzip {name}"),
    ".zip": ("compressed", "unpack it"),
}
_ALIKE = {
    ".hdf5": ".h5", ".hdf": ".h5", ".nc": ".h5", ".sqlite": ".db3", ".db": ".db3", ".p": ".pkl",
    ".pickle": ".pkl", ".joblib": ".pkl", ".xls": ".xlsx", ".ods": ".xlsx", ".arrow": ".feather",
    ".ndjson": ".jsonl", ".mdf": ".mf4", ".mot": ".sto",
}  # fmt: skip
_FIRST_BYTES = {  # of a file that may be named as a CSV → its suffix
    b"PK\x03\x04": ".xlsx", b"\xd0\xcf\x11\xe0": ".xlsx", b"PAR1": ".parquet",
    b"\x89MCAP": ".mcap", b"\x89HDF": ".h5", b"MATLAB": ".mat", b"SQLite": ".db3",
    b"\x1f\x8b": ".gz", b"ULog": ".ulg", b"MDF ": ".mf4", b"ARROW1": ".feather",
}  # fmt: skip


def check_format(path: Path) -> None:
    """Refuse a file of a format that is not read, and say how to convert it."""
    suffix = path.suffix.lower()
    if suffix in (".csv", *_AS_CSV) and path.is_file():
        with suppress(OSError), path.open("rb") as file:
            first = file.read(8)
            suffix = next((s for b, s in _FIRST_BYTES.items() if first.startswith(b)), suffix)
        if suffix in FORMATS[1:]:
            raise RecordingError(
                f"{path}: holds {suffix[1:].upper()}, not text; rename it to {path.stem}{suffix}"
            )
    if suffix in (*FORMATS, *_AS_CSV):
        return
    name, way_out = _OTHERS.get(_ALIKE.get(suffix, suffix), (f"{suffix or 'no'} file", ""))
    way_out = way_out.format(name=path.name, stem=path.stem) or "convert it"
    raise RecordingError(f"{path}: {name}; CSV, Parquet and MCAP are read: {way_out}")


def tables_in(path: Path) -> list[Path]:
    """The tables in a folder; of a file, or the stem of a recording, the path itself."""
    if not path.is_dir() or (path.name not in ("", "..") and table_beside(path)[0].is_file()):
        return [path]
    tables = sorted(p for p in path.iterdir() if p.suffix.lower() in FORMATS and p.is_file())
    if not tables:
        raise RecordingError(f"{path}: a folder without a table ({', '.join(FORMATS)})")
    return tables


def table_beside(path: Path, formats: Sequence[str] = FORMATS) -> tuple[Path, Path]:
    """Table and TOML of a path to either or to their stem, which may itself have dots in it.

    Of several tables, the first of ``formats`` that exists; of none, the first of ``formats``, or
    the path itself if it is a file of a format that is not read.
    """
    if path.name in ("", ".."):
        raise RecordingError(f"{path} is a folder; give the path of a recording's table")
    as_csv = path.suffix.lower() in _AS_CSV and path.is_file() and formats is FORMATS
    if as_csv or path.suffix.lower() in formats:
        return path, path.with_suffix(".toml")
    stem = path.name.removesuffix(".toml")
    tables = [path.with_name(stem + suffix) for suffix in formats]
    known = path.suffix.lower() in (*_OTHERS, *_ALIKE, *_AS_CSV)
    other = known or (path.suffix != ".toml" and path.exists())
    usual = path if other and formats is FORMATS else tables[0]
    table = next((table for table in tables if table.is_file()), usual)
    return table, path.with_name(stem + ".toml")


def check_file(path: Path, hint: str = "") -> None:
    """Raise `RecordingError` unless there is a file that can be opened.

    ``hint`` is appended to the message of a missing file, which names the nearest of the same kind.
    """
    try:
        path.open("rb").close()
    except FileNotFoundError:
        if not path.parent.is_dir():
            message = f"no such file, nor a folder {str(path.parent)!r}"
        else:
            files = [p.name for p in path.parent.iterdir() if p.is_file()]
            begins = path.name if not path.suffix else ""
            alike = [n for n in files if n.startswith(begins) and n.endswith(path.suffix)]
            folder = str(path).removesuffix(path.name)
            message = "no such file"
            message += suggestion("file", path.name, alike, folder) if alike else ""
        raise RecordingError(f"{path}: {message}{hint}") from None
    except OSError as error:
        raise RecordingError(f"{path}: cannot be read: {error.strerror}") from error


def read_text(path: Path, hint: str = "") -> str:
    """Read a UTF-8 text file (a byte-order mark is dropped), every line end turned into ``\\n``.

    Raises `RecordingError` for a file that cannot be opened, or is not UTF-8 (with row and column).
    """
    check_file(path, hint)
    try:
        return path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as error:
        lines = error.object[: error.start].decode("utf-8", "replace").splitlines(keepends=True)
        lines += [""] if not lines or lines[-1].endswith(("\n", "\r")) else []
        raise RecordingError(
            f"{path}, row {len(lines)}, column {lines[-1].count(',') + 1}: byte"
            f" 0x{error.object[error.start]:02x} is not UTF-8; save the file as UTF-8"
        ) from None


def read_toml(text: str, where: str) -> dict[str, Any]:
    """TOML text as plain values; messages begin with ``where``."""
    try:
        return tomllib.loads(text)
    except ValueError as error:
        raise RecordingError(f"{where}: not TOML: {error}") from None
