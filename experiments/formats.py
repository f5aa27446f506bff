"""One simulated rig in the formats of loggers, robots and instruments: is each read as its CSV is?

`python -m experiments.formats`. The readings are those of `models/rig/triangles.csv`, in counts: of
encoders of 4096 a turn, and of a load cell. A format can so hold all of them, and what differs is
its reader's fault. Each is read with a description that a user would write, and replayed; friction
is the one that leaves least of the load cell's readings, to second order.
"""

from __future__ import annotations

import json
import shutil
import sys
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
from mcap.writer import Writer as McapWriter
from pyarrow import parquet
from rosbags import rosbag2
from rosbags.typesys import Stores, get_typestore

from experiments.command import run_experiment, write_study
from tendon_mj import Recording, Simulator, example_rig, read_recording
from tendon_mj.cli import Output
from tendon_mj.errors import RecordingError
from tendon_mj.lab.data_check import timing_warnings
from tendon_mj.lab.recordings import read_table

AGREES = 1e-6  # relative, of readings and of what a replay leaves
STEP, CELL = 360.0 / 4096.0, 0.05  # of an encoder [deg], of the load cell [N]
RATE = 50.0  # [Hz]
FRICTIONS = (0.08, 0.1, 0.12)  # of replays, through whose errors a parabola is laid
START = 1_700_000_000_000_000_000  # [ns] since 1970
WORD = 2**32  # after which micros() begins again
Columns = Mapping[str, Sequence[object]]


@dataclass(frozen=True)
class Readings:
    """Of the spool, the cable and the lever, (n,) each: time [ms], and counts."""

    time: list[int]
    spool: list[int]
    cable: list[int]
    lever: list[int]

    def plain(self, clock: str = "time_ms") -> dict[str, list[Any]]:
        """The columns that rig.toml names."""
        return {
            clock: self.time,
            "spool_deg": [STEP * count for count in self.spool],
            "cable_N": [CELL * count for count in self.cable],
            "lever_deg": [STEP * count for count in self.lever],
        }


@dataclass(frozen=True)
class Written:
    """A file, and what its description says of it: lines of [columns]."""

    file: Path
    columns: str = ""


@dataclass(frozen=True)
class Outcome:
    """Result of reading a format.

    Attributes:
        format: its name.
        rows: that were read; 0 if it was refused.
        off: largest difference of a reading from the CSV's, over the largest reading.
        left: rms error of a replay over the noise [-].
        friction: that leaves least [-].
        said: refusals and warnings, a line each.
    """

    format: str
    rows: int = 0
    off: float = np.nan
    left: float = np.nan
    friction: float = np.nan
    said: tuple[str, ...] = ()


def readings(rows: int | None = None) -> Readings:
    """The first readings of the example rig, or all."""
    table = read_table(Path(example_rig()) / "triangles.csv")

    def counts(column: str, step: float) -> list[int]:
        return [round(value / step) for value in table[column][:rows].tolist()]

    turn = np.radians(STEP)
    return Readings(
        counts("time_s", 1e-3),
        counts("spool_rad", turn),
        counts("cable_N", CELL),
        counts("lever_rad", turn),
    )


def _table(
    path: Path, columns: Columns, above: str = "", between: str = ",", decimal: str = "."
) -> Path:
    rows = [list(columns), *zip(*columns.values(), strict=True)]
    lines = (between.join(str(cell).replace(".", decimal) for cell in row) for row in rows)
    path.write_text(above + "\n".join(lines) + "\n", encoding="utf-8")
    return path


# --- tables


def _csv(path: Path, read: Readings) -> Written:
    return Written(_table(path.with_suffix(".csv"), read.plain()))


def _parquet(path: Path, read: Readings) -> Written:
    file = path.with_suffix(".parquet")
    parquet.write_table(pa.table(read.plain()), file)
    return Written(file)


def _dynamixel(path: Path, read: Readings) -> Written:
    """Position and current as the servo's table has them, where 16 bits have no sign."""
    columns = {
        "timestamp_ms": read.time,
        "present_position_1": [2048 + count for count in read.spool],
        "present_current_1": [count % 2**16 for count in read.cable],
        "present_position_2": [2048 + count for count in read.lever],
    }
    turn = f'factor = {STEP}, offset = -180.0, unit = "deg"'
    return Written(
        _table(path.with_suffix(".csv"), columns),
        f"""time_ms = "timestamp_ms"
spool_deg = {{ column = "present_position_1", {turn} }}
cable_N = {{ column = "present_current_1", factor = {CELL}, period = 65536 }}
lever_deg = {{ column = "present_position_2", {turn} }}
""",
    )


def _machine(path: Path, read: Readings) -> Written:
    """A preamble, quoted names, and a row of units."""
    seconds = {"time": [t / 1000.0 for t in read.time]} | read.plain()
    columns = ((f'"{name}"', seconds[key]) for name, key in _NAMES.items())
    units = ("(s)", "(deg)", "(N)", "(deg)")
    below = {n: [f'"{u}"', *values] for (n, values), u in zip(columns, units, strict=True)}
    file = _table(path.with_suffix(".csv"), below, '"Specimen","1"\n"Rate","10 mm/min"\n\n')
    return Written(file, "".join(f'{_OURS[k]} = "{n}"\n' for n, k in _NAMES.items()))


_NAMES = {"Time": "time", "Spool": "spool_deg", "Load": "cable_N", "Lever": "lever_deg"}
_OURS = {"time": "time_s"} | {name: name for name in list(_NAMES.values())[1:]}


def _commas(path: Path, read: Readings) -> Written:
    """Decimal commas between tabs."""
    seconds = {"time": [t / 1000.0 for t in read.time]} | read.plain()
    units = {"time": "Zeit [s]", "spool_deg": "Spule [deg]", "cable_N": "Kraft [N]"}
    names = units | {"lever_deg": "Hebel [deg]"}
    file = path.with_suffix(".csv")
    _table(file, {names[key]: seconds[key] for key in names}, between="\t", decimal=",")
    return Written(file, "".join(f'{_OURS[key]} = "{name}"\n' for key, name in names.items()))


def _rostopic(path: Path, read: Readings) -> Written:
    """`rostopic echo -p` of joint states, of which the effort is the load cell."""
    plain = read.plain()
    columns = {
        "%time": [START + t * 10**6 for t in read.time],
        "field.header.frame_id": ["base"] * len(read.time),
        "field.position0": np.radians(plain["spool_deg"]).tolist(),
        "field.position1": np.radians(plain["lever_deg"]).tolist(),
        "field.effort0": plain["cable_N"],
    }
    return Written(
        _table(path.with_suffix(".csv"), columns),
        """time_ns = "%time"
spool_deg = { column = "field.position0", unit = "rad" }
lever_deg = { column = "field.position1", unit = "rad" }
cable_N = "field.effort0"
""",
    )


def _dash(path: Path, read: Readings) -> Written:
    """A dash where the load cell gave nothing."""
    plain = read.plain()
    cable = ["-" if k % 7 == 3 else force for k, force in enumerate(plain["cable_N"])]
    return Written(_table(path.with_suffix(".csv"), plain | {"cable_N": cable}))


def _micros(path: Path, read: Readings) -> Written:
    """A clock of 32 bits that begins again."""
    clock = [(WORD - 3_000_000 + 1000 * t) % WORD for t in read.time]
    columns = {"micros": clock} | read.plain()
    del columns["time_ms"]
    file = _table(path.with_suffix(".csv"), columns)
    return Written(file, f'time_us = {{ column = "micros", period = {WORD} }}\n')


def _restarted(path: Path, read: Readings) -> Written:
    """A logger that was started twice into one file."""
    half, plain = len(read.time) // 2, read.plain()
    again = {"time_ms": [t - read.time[half] for t in read.time[half:]]}
    columns = {
        name: [*values[:half], name, *again.get(name, values[half:])]
        for name, values in plain.items()
    }
    return Written(_table(path.with_suffix(".csv"), columns))


def _normalised(path: Path, read: Readings) -> Written:
    """Positions from -100 to 100 of half a turn."""
    plain = read.plain()
    columns = {
        "timestamp": [t / 1000.0 for t in read.time],
        "spool.pos": [angle / 1.8 for angle in plain["spool_deg"]],
        "lever.pos": [angle / 1.8 for angle in plain["lever_deg"]],
        "cable_N": plain["cable_N"],
    }
    return Written(
        _table(path.with_suffix(".csv"), columns),
        """time_s = "timestamp"
spool_deg = { column = "spool.pos", factor = 1.8, unit = "deg" }
lever_deg = { column = "lever.pos", factor = 1.8, unit = "deg" }
""",
    )


def _unsaid(path: Path, read: Readings) -> Written:
    """The same without an entry for them."""
    return Written(_normalised(path, read).file, 'time_s = "timestamp"\n')


def _seconds(path: Path, read: Readings) -> Written:
    """The header says ms, the numbers are seconds."""
    seconds = [t / 1000.0 for t in read.time]
    return Written(_table(path.with_suffix(".csv"), read.plain() | {"time_ms": seconds}))


# --- logs and episodes


def _mcap(path: Path, read: Readings) -> Written:
    """Messages in JSON."""
    file = path.with_suffix(".mcap")
    with file.open("wb") as stream:
        writer = McapWriter(stream)
        writer.start()
        schema = writer.register_schema("reading", "jsonschema", b"{}")
        topic = writer.register_channel("/rig", "json", schema)
        for row in zip(*read.plain().values(), strict=True):
            stamp = START + row[0] * 10**6
            data = json.dumps(dict(zip(("spool", "cable", "lever"), row[1:], strict=True)))
            writer.add_message(topic, log_time=stamp, data=data.encode(), publish_time=stamp)
        writer.finish()  # type: ignore[no-untyped-call]
    names = {"spool_deg": "spool", "cable_N": "cable", "lever_deg": "lever"}
    entries = (f'{c} = {{ topic = "/rig", field = "{f}" }}\n' for c, f in names.items())
    return Written(file, "".join(entries))


def _bag(storage: str) -> Callable[[Path, Readings], Written]:
    """A bag of ROS 2: joint states, and the wrench of the load cell."""

    def write(path: Path, read: Readings) -> Written:
        store = get_typestore(Stores.ROS2_HUMBLE)
        make: Callable[..., Any] = lambda kind, *fields: store.types[kind](*fields)  # noqa: E731
        vector, none = "geometry_msgs/msg/Vector3", np.zeros(0)
        joints, cell = "sensor_msgs/msg/JointState", "geometry_msgs/msg/WrenchStamped"
        plugin = rosbag2.StoragePlugin[storage]
        with rosbag2.Writer(path, version=9, storage_plugin=plugin) as writer:
            to_joints = writer.add_connection("/joint_states", joints, typestore=store)
            to_cell = writer.add_connection("/cell", cell, typestore=store)
            for t, spool, force, lever in zip(*read.plain().values(), strict=True):
                stamp = START + t * 10**6
                time = make("builtin_interfaces/msg/Time", *divmod(stamp, 10**9))
                header = make("std_msgs/msg/Header", time, "")
                places = np.radians([spool, lever])
                state = make(joints, header, ["spool", "lever"], places, none, none)
                pull, no_torque = make(vector, force, 0.0, 0.0), make(vector, 0.0, 0.0, 0.0)
                wrench = make(cell, header, make("geometry_msgs/msg/Wrench", pull, no_torque))
                writer.write(to_joints, stamp, store.serialize_cdr(state, joints))
                writer.write(to_cell, stamp, store.serialize_cdr(wrench, cell))
        return Written(
            path,
            """spool_deg = { topic = "/joint_states", field = "position.spool" }
cable_N = { topic = "/cell", field = "wrench.force.x" }
lever_deg = { topic = "/joint_states", field = "position.lever" }
""",
        )

    return write


def _episode(version: int, *, stamps: bool = True) -> Callable[[Path, Readings], Written]:
    """An episode of a dataset of LeRobot, in single precision."""

    def write(path: Path, read: Readings) -> Written:
        plain, single = read.plain(), pa.float32()
        vectors = {
            "action": {"spool.pos": plain["spool_deg"]},
            "observation.state": {"lever.pos": plain["lever_deg"], "cable": plain["cable_N"]},
        }
        columns = {
            name: pa.array(np.transpose([*of.values()]).tolist(), pa.list_(single))
            for name, of in vectors.items()
        }
        columns["episode_index"] = pa.array([0] * len(read.time))
        if stamps:
            columns["timestamp"] = pa.array([t / 1000.0 for t in read.time], single)
        file = "episode_000000" if version == 2 else "file-000"
        data = path / "data" / "chunk-000"
        data.mkdir(parents=True)
        parquet.write_table(pa.table(columns), data / f"{file}.parquet")
        features = {
            name: {"dtype": "float32", "shape": [len(of)], "names": [*of]}
            for name, of in vectors.items()
        }
        info = {"total_episodes": 1, "fps": RATE, "features": features}
        (path / "meta").mkdir()
        (path / "meta" / "info.json").write_text(json.dumps(info), encoding="utf-8")
        return Written(
            path / "episode_0",
            """spool_deg = { column = "action.spool.pos", unit = "deg" }
lever_deg = { column = "observation.state.lever.pos", unit = "deg" }
cable_N = { column = "observation.state.cable", unit = "N" }
""",
        )

    return write


FORMATS: Mapping[str, Callable[[Path, Readings], Written]] = {
    "CSV": _csv,
    "Parquet": _parquet,
    "MCAP, JSON": _mcap,
    "bag of ROS 2, SQLite": _bag("SQLITE3"),
    "bag of ROS 2, MCAP": _bag("MCAP"),
    "LeRobot 2.1": _episode(2),
    "LeRobot 3": _episode(3),
    "LeRobot 3 without timestamps": _episode(3, stamps=False),
    "Dynamixel, counts": _dynamixel,
    "preamble and units": _machine,
    "tabs, decimal commas": _commas,
    "rostopic echo": _rostopic,
    "dashes": _dash,
    "clock of 32 bits": _micros,
    "started twice": _restarted,
    "-100 to 100": _normalised,
    "-100 to 100, not said": _unsaid,
    "ms that are s": _seconds,
}


def outcome(name: str, folder: Path, read: Readings, plain: Recording | None) -> Outcome:
    """Write a format, read it, and hold it against the recording of the CSV.

    Args:
        name: of `FORMATS`.
        folder: for the files.
        read: what they hold.
        plain: the recording of the CSV; None to read that.
    """
    written = FORMATS[name](folder / name.replace(" ", "_").replace(",", ""), read)
    description = folder / f"{written.file.name} of {name}.toml"
    rig = (Path(example_rig()) / "rig.toml").read_text(encoding="utf-8")
    description.write_text(f"{rig}\n[columns]\n{written.columns}", encoding="utf-8")
    try:
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            recording = read_recording(written.file, description)
    except RecordingError as error:
        return Outcome(name, said=tuple(str(error).splitlines()))
    said = [str(warning.message) for warning in caught]
    said += [warning.sentence for warning in timing_warnings(recording)]
    plain = plain or recording
    since = recording.time - recording.time[0]
    rows = np.argmin(np.abs(since[:, None] - plain.time), axis=1)
    pairs = [(since, plain.time)] + [(recording.columns[c], x) for c, x in plain.columns.items()]
    off = max(float(np.abs(x - y[rows]).max() / np.abs(y).max()) for x, y in pairs)
    return Outcome(name, recording.time.size, off, *_replayed(recording), tuple(said))


def _replayed(recording: Recording) -> tuple[float, float]:
    """What a replay leaves [noise], and the friction that leaves least of the load cell [-]."""
    given = [{}, *({"sheath.friction": friction} for friction in FRICTIONS)]
    answers, squares = Simulator([recording])(given), list[list[float]]()
    for column, measured in recording.measured.items():
        off = [shown[column] - recording.columns[column] for (shown,) in answers]
        squares.append([float(np.mean((error / (measured.noise or 1.0)) ** 2)) for error in off])
    of_cell = squares[list(recording.measured).index("cable_N")][1:]
    curvature, slope, _ = np.polyfit(FRICTIONS, of_cell, 2)
    every = float(np.sqrt(np.mean([of_column[0] for of_column in squares])))
    return every, float(-0.5 * slope / curvature)


def compare_formats(
    out: Path = Path("out/formats"), rows: int | None = None, formats: tuple[str, ...] = ()
) -> None:
    """Read one simulated rig in each format, and hold it against its CSV.

    Args:
        out: folder for the files, result.json and the table.
        rows: of the recording; all unless given.
        formats: names of some; all unless given.
    """
    output, files = Output(out), out / "files"
    shutil.rmtree(files, ignore_errors=True)
    files.mkdir(parents=True)
    shutil.copy(Path(example_rig()) / "rig.xml", files)
    outcomes = compared(files, rows, formats or tuple(FORMATS))
    result = {"formats": [vars(one) for one in outcomes]}
    write_study(output, [], result, table(outcomes), summary(outcomes))


def compared(folder: Path, rows: int | None, formats: Sequence[str]) -> list[Outcome]:
    """Outcomes of some formats, that of the CSV first; ``folder`` has the rig's model."""
    read = readings(rows)
    first = outcome("CSV", folder, read, None)
    plain = read_recording(folder / "CSV.csv", folder / "CSV.csv of CSV.toml")
    return [first, *(outcome(name, folder, read, plain) for name in formats if name != "CSV")]


def agrees(one: Outcome, plain: Outcome) -> bool:
    """True if a format's rows, and what a replay of them says, are those of the CSV."""
    numbers = [(one.left, plain.left), (one.friction, plain.friction)]
    return one.off <= AGREES and all(abs(x / y - 1.0) <= AGREES for x, y in numbers)


def table(outcomes: Sequence[Outcome]) -> str:
    """Table in Markdown."""
    lines = ["| format | rows | as the CSV | off | left | friction | said |", "|" + "---|" * 7]
    for one in outcomes:
        same = "yes" if agrees(one, outcomes[0]) else "no"
        numbers = f"{one.off:.1e} | {one.left:.6f} | {one.friction:.6f}"
        lines.append(f"| {one.format} | {one.rows} | {same} | {numbers} | {' '.join(one.said)} |")
    return "\n".join(lines) + "\n"


def summary(outcomes: Sequence[Outcome]) -> list[str]:
    """The figures that count, and each format that differs."""
    plain, *others = outcomes
    same = [one for one in others if agrees(one, plain)]
    silent = [one for one in others if one not in same and not one.said]
    return [
        f"{len(same)} of {len(others)} formats as the CSV",
        f"{len(others) - len(same) - len(silent)} said, {len(silent)} otherwise in silence",
        *(f"{one.format}: {one.said[0] if one.said else one}" for one in others if one not in same),
    ]


if __name__ == "__main__":
    sys.exit(run_experiment(compare_formats, "formats"))
