"""Files of the rig are read by their names; anything else is refused."""

import numpy as np
import pytest

from experiments.cable_tool.recording import COLUMNS, read_folder, read_recording
from tendon_mj.errors import RecordingError
from tests.refusals import refusing

HEADER = ",".join(COLUMNS)
ROWS = "\n".join(f"{t},{t},{0.1 * t},{-t},{-0.05 * t}" for t in (0.0, 1.0, 2.0))


def written(folder, name, header=HEADER, rows=ROWS):
    path = folder / f"{name}.csv"
    path.write_text(f"{header}\n{rows}\n")
    return path


@pytest.mark.parametrize(
    ("name", "pose", "pitch", "roll", "load", "rate", "group"),
    [
        ("tool_L4_0.1Hz_load010", "straight", 0, 0, 0.1, "0.1Hz", "straight"),
        ("tool_L4_f2_load100", "straight", 0, 0, 1.0, "f2", "straight"),
        ("pitch1_yaw0_load20", "pitch1", -60, 0, 0.2, "", "pitch"),
        ("pitch4_yaw0_load20", "pitch4", 30, 0, 0.2, "", "pitch"),
        ("roll5_yaw0_load80", "roll5", 0, 90, 0.8, "", "roll"),
    ],
)
def test_a_name_says_pose_load_and_rate(tmp_path, name, pose, pitch, roll, load, rate, group):
    found = read_recording(written(tmp_path, name))
    assert (found.name, found.pose, found.rate, found.group) == (name, pose, rate, group)
    assert found.load_share == pytest.approx(load)
    assert np.degrees([found.pitch, found.roll]) == pytest.approx([pitch, roll])
    np.testing.assert_allclose(found.load, [0.0, 0.05, 0.1])


def test_what_is_not_of_the_rig_is_refused(tmp_path):
    with refusing(RecordingError, "pitchN_yawN_loadPERCENT"):
        read_recording(written(tmp_path, "other"))
    with refusing(RecordingError, "row 1"):
        read_recording(written(tmp_path, "roll1_yaw0_load40", header="a,b"))
    rows = "0,nan,0,0,0\n" + "\n".join(f"{k},0,0,0,0" for k in range(1, 5))
    with refusing(RecordingError, "row 2 … nan"):
        read_recording(written(tmp_path, "roll1_yaw0_load40", rows=rows))
    with refusing(RecordingError, "no CSV file"):
        read_folder(tmp_path / "empty")
