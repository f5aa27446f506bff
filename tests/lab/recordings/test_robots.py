"""Laws of the logs of robots: LeRobot's datasets and bags of ROS are what a CSV is."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from tendon_mj.cli.recordings import check
from tendon_mj.errors import RecordingError
from tendon_mj.lab.diagnosis.audit import collect_provenance, files_of
from tendon_mj.lab.recordings import Recording, read_recording, tables_in
from tests.lab.recordings.tables import bag, dataset
from tests.refusals import refusing

RATE = 50.0  # [Hz]
TIME = np.arange(120) / RATE
GOAL = np.rint(2048.0 + 400.0 * np.sin(3.0 * TIME))  # counts of 4096 a turn
LEVER = 20.0 * np.sin(3.0 * TIME - 0.2)  # [deg]
PULL = 20.0 + 3.0 * np.cos(5.0 * TIME)  # [N]
TOML = """model = "bench"
source = "made up"
[drive]
goal_deg = "reel"
[measured]
lever_deg = { sensor = "angle" }
pull_N = { sensor = "input_tension" }
"""
OF_DATASET = """[columns]
goal_deg = { column = "action.motor.pos", factor = 0.087890625, offset = -180.0, unit = "deg" }
lever_deg = { column = "observation.state.lever.pos", unit = "deg" }
pull_N = { column = "observation.load.0", unit = "N" }
"""
OF_BAG = """[columns]
goal_deg = { topic = "/goal", field = "data.0", factor = 0.087890625, offset = -180.0 }
lever_deg = { topic = "/joint_states", field = "position.lever" }
pull_N = { topic = "/cell", field = "wrench.force.z" }
"""


def of_csv(folder: Path) -> Recording:
    rows = np.transpose([TIME, GOAL * 0.087890625 - 180.0, LEVER, PULL]).tolist()
    text = "\n".join(",".join(map(repr, row)) for row in rows)
    (folder / "r.csv").write_text(f"time_s,goal_deg,lever_deg,pull_N\n{text}\n")
    (folder / "r.toml").write_text(TOML)
    return read_recording(folder / "r.csv")


def write_dataset(folder: Path, version: int) -> Path:
    """Two episodes, of which the second is the recording."""
    vectors = {
        "action": {"lever.pos": [LEVER[:40], LEVER], "motor.pos": [GOAL[:40], GOAL]},
        "observation.state": {"motor.pos": [GOAL[:40], GOAL], "lever.pos": [LEVER[:40], LEVER]},
        "observation.load": {"z": [PULL[:40], PULL]},
    }
    (folder / "all.toml").write_text(TOML + OF_DATASET)
    return dataset(folder / "ds", version, vectors, RATE)


def write_bag(folder: Path, storage: str) -> Path:
    """Joints are in another order in every other message."""
    sent = []
    for k, (t, goal, lever, pull) in enumerate(zip(TIME, GOAL, LEVER, PULL, strict=True)):
        names, places = ["motor", "lever"], np.radians([0.0, lever])
        joints = {"name": names[:: 1 - 2 * (k % 2)], "position": places[:: 1 - 2 * (k % 2)].copy()}
        empty = {"velocity": np.zeros(0), "effort": np.zeros(0)}
        vector = "geometry_msgs/msg/Vector3"
        force = {"kind": vector, "fields": {"x": 0.0, "y": 0.0, "z": pull}}
        torque = {"kind": vector, "fields": {"x": 0.0, "y": 0.0, "z": 0.0}}
        wrench = {"kind": "geometry_msgs/msg/Wrench", "fields": {"force": force, "torque": torque}}
        layout = {"dim": [], "data_offset": 0}
        layout = {"kind": "std_msgs/msg/MultiArrayLayout", "fields": layout}
        data = {"layout": layout, "data": np.array([goal])}
        sent += [
            ("/goal", t, "std_msgs/msg/Float64MultiArray", data),
            ("/joint_states", t, "sensor_msgs/msg/JointState", {**joints, **empty}),
            ("/cell", t, "geometry_msgs/msg/WrenchStamped", {"wrench": wrench}),
        ]
    (folder / "run.toml").write_text(TOML + OF_BAG)
    return bag(folder / "run", storage, *sent)


def is_same(recording: Recording, other: Recording) -> None:
    assert list(recording.columns) == list(other.columns)
    assert_allclose(recording.time, other.time, atol=1e-6)
    for column, values in other.columns.items():
        assert_allclose(recording.columns[column], values, rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize("version", [2, 3])
def test_an_episode_and_a_csv_are_the_same_recording(tmp_path: Path, version: int) -> None:
    folder = write_dataset(tmp_path, version)
    for name in ("episode_1", "episode_000001"):
        read = read_recording(folder / name, tmp_path / "all.toml")
        is_same(read, of_csv(tmp_path))
    assert read.name == "episode_000001"
    (folder / "episode_1.toml").write_text(TOML + OF_DATASET)
    is_same(read_recording(folder / "episode_1"), read)
    is_same(read_recording(folder / "episode_1.toml"), read)
    assert read_recording(folder / "episode_0", tmp_path / "all.toml").time.size == 40


def test_an_episode_without_timestamps_has_the_rate_of_its_dataset(tmp_path: Path) -> None:
    pq = pytest.importorskip("pyarrow.parquet")
    folder = write_dataset(tmp_path, 3)
    (file,) = folder.rglob("*.parquet")
    pq.write_table(pq.read_table(file).drop_columns(["timestamp"]), file)
    path = folder / "meta" / "info.json"
    info = json.loads(path.read_text())
    with refusing(RecordingError, "no column is named 'time_s'", "period = …"):
        read_recording(folder / "episode_1", tmp_path / "all.toml")
    path.write_text(json.dumps(info | {"fps": RATE}))
    is_same(read_recording(folder / "episode_1", tmp_path / "all.toml"), of_csv(tmp_path))
    (tmp_path / "slow.toml").write_text(f"period = {2.0 / RATE}\n{TOML}{OF_DATASET}")
    slow = read_recording(folder / "episode_1", tmp_path / "slow.toml")
    assert_allclose(slow.time, 2.0 * TIME, atol=1e-12)


@pytest.mark.parametrize("storage", ["MCAP", "SQLITE3"])
def test_a_bag_and_a_csv_are_the_same_recording(tmp_path: Path, storage: str) -> None:
    """Standard messages are in SI by their definition, whatever the column is named."""
    path = write_bag(tmp_path, storage)
    plain = of_csv(tmp_path)
    for either in (path, path.with_suffix(".toml"), next(path.glob("run*.[dm]*"))):
        is_same(read_recording(either, tmp_path / "run.toml"), plain)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('"/goal"', '"/gaol"', "unknown topic '/gaol'; did you mean '/goal'?"),
        ("position.lever", "position.level", "unknown field 'level'; did you mean 'lever'?"),
        ("position.lever", "position.2", "unknown field '2'"),
        ("wrench.force.z", "wrench.forces.z", "did you mean 'force'?"),
        ("wrench.force.z", "wrench.torque.z", "geometry_msgs/msg/WrenchStamped is in Nm"),
        ('position.lever"', 'position.lever", factor = 2.0', "say unit = 'deg' or another"),
    ],
)
def test_a_bag_is_refused_with_topic_and_field(
    tmp_path: Path, old: str, new: str, said: str
) -> None:
    path = write_bag(tmp_path, "MCAP")
    toml = path.with_suffix(".toml")
    toml.write_text(toml.read_text().replace(old, new))
    with refusing(RecordingError, "run", said):
        read_recording(path)


def test_broken_bags_are_refused_by_name(tmp_path: Path) -> None:
    path = write_bag(tmp_path, "SQLITE3")
    file = next(path.glob("*.db3"))
    file.write_bytes(file.read_bytes()[:3000])
    with refusing(RecordingError, "run: not a bag of ROS"):
        read_recording(path)
    file.unlink()
    with refusing(RecordingError, "run: not a bag of ROS"):
        read_recording(path)


def edited(change: Callable[[dict[str, object]], object]) -> Callable[[Path], object]:
    def edit(folder: Path) -> None:
        path = folder / "meta" / "info.json"
        info = json.loads(path.read_text())
        change(info)
        path.write_text(json.dumps(info))

    return edit


@pytest.mark.parametrize(
    ("change", "name", "said"),
    [
        (lambda folder: None, "", "give one of its episodes, such as"),
        (lambda folder: None, "episode_7", "episode_7: no frame of episode 7"),
        (edited(lambda info: info.pop("features")), "episode_1", "info.json: not a dataset"),
        (
            edited(lambda info: info["features"]["action"].update(names=["a", "a"])),
            "episode_1",
            "unknown column 'action.motor.pos'",
        ),
        (
            lambda folder: [path.unlink() for path in folder.rglob("*.parquet")],
            "episode_1",
            "download the dataset",
        ),
        (
            lambda folder: [path.write_text("version https://") for path in folder.rglob("*.pa*")],
            "episode_1",
            "not a Parquet file",
        ),
    ],
)
def test_a_dataset_is_refused_with_what_is_wrong(
    tmp_path: Path, change: Callable[[Path], object], name: str, said: str
) -> None:
    folder = write_dataset(tmp_path, 3)
    change(folder)
    with refusing(RecordingError, "ds", said):
        read_recording(folder / name, tmp_path / "all.toml")


def test_a_file_of_several_episodes_is_refused_as_that(tmp_path: Path) -> None:
    file = next(write_dataset(tmp_path, 3).rglob("*.parquet"))
    with refusing(RecordingError, "file-000.parquet: holds episodes 0 to 1", "episode_0"):
        read_recording(file, tmp_path / "all.toml")


RIG = """model = "bench"
source = "made up"
[drive]
reel_m = "reel"
[measured]
pull_N = { sensor = "input_tension" }
[columns]
reel_m = { column = "action.reel", factor = 1e-3, unit = "m" }
pull_N = { column = "observation.state.cell", unit = "N" }
"""


def test_check_takes_every_episode_of_a_dataset(tmp_path: Path) -> None:
    reel, pull = [np.sin(TIME), np.sin(2.0 * TIME)], [20.0 + np.sin(TIME)] * 2
    vectors = {"action": {"reel": reel}, "observation.state": {"cell": pull}}
    folder = dataset(tmp_path / "ds", 3, vectors, RATE)
    (tmp_path / "all.toml").write_text(RIG)
    result = check((folder,), out=tmp_path / "out", description=tmp_path / "all.toml")
    names = [one["name"] for one in result["recordings"]]  # type: ignore[attr-defined]
    assert names == ["episode_000000", "episode_000001"]


def test_a_folder_holds_its_bags_and_tables(tmp_path: Path) -> None:
    for name in ("a/metadata.yaml", "b/other.yaml", "c.csv"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).touch()
    assert tables_in(tmp_path) == [tmp_path / "a", tmp_path / "c.csv"]
    assert tables_in(tmp_path / "a") == [tmp_path / "a"]


def test_the_files_of_an_episode_and_of_a_bag_are_those_that_are_hashed(tmp_path: Path) -> None:
    (tmp_path / "a").mkdir()
    episode = write_dataset(tmp_path / "a", 2) / "episode_1"
    run = tmp_path / "run"
    run.mkdir()
    (run / "metadata.yaml").write_text("")
    files = files_of([episode, run], tmp_path / "a" / "all.toml", [])
    names = {path.name for path in files}
    assert names == {"episode_000001.parquet", "info.json", "metadata.yaml", "all.toml"}
    assert len(collect_provenance(files=files).files) == len(files)
