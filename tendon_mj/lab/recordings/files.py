"""Files of a recording: where they are, their formats, and text with errors that say where."""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from tendon_mj.errors import MissingPackageError, RecordingError, suggestion

# in the order in which a stem is sought
FORMATS = (".csv", ".parquet", ".mcap", ".db3", ".bag")
_READ = "CSV, Parquet, MCAP, bags of ROS and datasets of LeRobot are read"
_EPISODE = re.compile(r"episode_(\d+)")
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
    ".hdf5": ".h5", ".hdf": ".h5", ".nc": ".h5", ".p": ".pkl", ".pickle": ".pkl",
    ".joblib": ".pkl", ".xls": ".xlsx", ".ods": ".xlsx", ".arrow": ".feather",
    ".ndjson": ".jsonl", ".mdf": ".mf4", ".mot": ".sto",
}  # fmt: skip
_FIRST_BYTES = {  # of a file that may be named as a CSV → its suffix
    b"PK\x03\x04": ".xlsx", b"\xd0\xcf\x11\xe0": ".xlsx", b"PAR1": ".parquet",
    b"\x89MCAP": ".mcap", b"\x89HDF": ".h5", b"MATLAB": ".mat", b"SQLite": ".db3",
    b"\x1f\x8b": ".gz", b"ULog": ".ulg", b"MDF ": ".mf4", b"ARROW1": ".feather",
}  # fmt: skip


def check_format(path: Path) -> None:
    """Refuse a file of a format that is not read, and say how to convert it."""
    if is_bag(path) or episode_of(path) is not None:
        return
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
    raise RecordingError(f"{path}: {name}; {_READ}: {way_out}")


def is_bag(path: Path) -> bool:
    """True for a bag of ROS: the folder of one, or a file of it."""
    return path.suffix in (".db3", ".bag") or (path / "metadata.yaml").is_file()


def episode_of(path: Path) -> int | None:
    """The number of an episode of a dataset of LeRobot: ``<its folder>/episode_3``; or None."""
    name = _EPISODE.fullmatch(path.name)
    return int(name[1]) if name and _info(path.parent).is_file() else None


def read_info(folder: Path) -> dict[str, Any]:
    """What the dataset of LeRobot in a folder says of itself: its episodes and its features."""
    path = _info(folder)
    try:
        info = json.loads(read_text(path))
        counts = {"total_episodes": int(info["total_episodes"]), "fps": float(info.get("fps", 0.0))}
        return {**counts, "features": dict(info["features"])}
    except (ValueError, KeyError, TypeError) as error:
        raise RecordingError(
            f"{path}: not a dataset of LeRobot, of version 2 or 3: {error!r}"
        ) from None


def _info(folder: Path) -> Path:
    return folder / "meta" / "info.json"


def episode_files(path: Path, episode: int) -> list[Path]:
    """Files of a dataset that may hold an episode: its own (version 2), or all (version 3)."""
    data = path.parent / "data"
    own = data.rglob(f"episode_{episode:06d}.parquet")
    files = sorted(own) or sorted(data.rglob("*.parquet"))
    if not files:
        raise RecordingError(f"{data}: holds no Parquet file; download the dataset with its data")
    return files


def files_in(table: Path) -> list[Path]:
    """Files in which a recording is: those of a bag's folder, those of an episode, or one."""
    if (episode := episode_of(table)) is not None:
        return [_info(table.parent), *episode_files(table, episode)]
    return sorted(filter(Path.is_file, table.iterdir())) if table.is_dir() else [table]


def tables_in(path: Path) -> list[Path]:
    """The tables, bags or episodes in a folder; of a file, or a recording's stem, the path."""
    if _info(path).is_file():
        total = read_info(path)["total_episodes"]
        return [path / f"episode_{k:06d}" for k in range(total)]
    is_table = path.name not in ("", "..") and table_beside(path)[0].is_file()
    if not path.is_dir() or is_bag(path) or is_table:
        return [path]
    tables = sorted(
        p for p in path.iterdir() if (p.suffix.lower() in FORMATS and p.is_file()) or is_bag(p)
    )
    if not tables:
        raise RecordingError(f"{path}: a folder without a table ({', '.join(FORMATS)})")
    return tables


def missing_reader(path: Path, kind: str, package: str, extra: str) -> MissingPackageError:
    """The error that a format is read through a package which is not installed."""
    return MissingPackageError(
        f"{path}: {kind} is read through {package}, which is not installed;"
        f" pip install 'tendon-mj[{extra}]'"
    )


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
    bare = path.with_name(stem)
    if formats is FORMATS and (episode_of(bare) is not None or (bare.is_dir() and is_bag(bare))):
        usual = bare
    table = next((table for table in tables if table.is_file()), usual)
    return table, path.with_name(stem + ".toml")


def check_file(path: Path, hint: str = "") -> None:
    """Raise `RecordingError` unless there is a file that can be opened.

    So is a bag's folder and an episode of a dataset. ``hint`` is appended to the message of a
    missing file, which names the nearest of the same kind.
    """
    if (path.is_dir() and is_bag(path)) or episode_of(path) is not None:
        return
    if _info(path).is_file():
        raise RecordingError(
            f"{path}: a dataset of LeRobot; give one of its episodes, such as"
            f" {path / 'episode_000000'}"
        )
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
