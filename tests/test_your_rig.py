"""The page "Your rig in 20 minutes" and its notebook run as they stand, to the right verdict."""

import json
import os
import re
import sys
from pathlib import Path

import nbformat
import pytest
from jupyter_client.kernelspec import KernelSpecManager
from nbclient import NotebookClient

from experiments.make_notebook import NOTEBOOK, PAGE, notebook_text, sources
from experiments.one_capstan import FRICTION, PLAY, PRETENSION
from tendon_mj.errors import RecordingError
from tendon_mj.lab.recordings import read_recording
from tendon_mj.models import example_rig

ROOT = Path(__file__).parents[1]


@pytest.fixture(scope="module")
def ran(tmp_path_factory):
    """An empty folder in which the notebook ran, and all that it printed."""
    folder = tmp_path_factory.mktemp("rig")
    notebook = nbformat.read(NOTEBOOK, as_version=4)
    with pytest.MonkeyPatch.context() as patch:
        # the package of this clone, and the kernel of this Python wherever it is installed
        patch.setenv("PYTHONPATH", os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")]))
        patch.setenv("JUPYTER_PATH", str(Path(sys.prefix) / "share" / "jupyter"))
        patch.setenv("JUPYTER_PLATFORM_DIRS", "1")
        patch.setenv("IPYTHONDIR", str(folder / ".ipython"))
        patch.setenv("COLUMNS", "200")
        assert "python3" in KernelSpecManager().find_kernel_specs()
        client = NotebookClient(notebook, timeout=600, resources={"metadata": {"path": folder}})
        client.execute()
    printed = "".join(
        output.get("text", "")
        for cell in notebook.cells
        if cell.cell_type == "code"
        for output in cell.outputs
    )
    return folder, printed


def test_the_notebook_is_made_of_the_page():
    text = NOTEBOOK.read_text("utf-8")
    made = notebook_text(PAGE.read_text("utf-8"))
    assert sources(text) == sources(made), "python -m experiments.make_notebook"
    for cell in json.loads(text)["cells"]:
        for target in re.findall(r"\]\(([^)#]+)[^)]*\)", "".join(cell["source"])):
            assert target.startswith("http") or (NOTEBOOK.parent / target).exists(), target


def test_the_notebook_is_stored_with_what_it_prints_and_its_pictures():
    cells = json.loads(NOTEBOOK.read_text("utf-8"))["cells"]
    outputs = [output for cell in cells for output in cell.get("outputs", [])]
    assert sum("image/png" in output.get("data", {}) for output in outputs) >= 6
    assert not any(output["output_type"] == "error" for output in outputs)
    assert "an elastic mount of the sheath" in json.dumps(outputs)
    assert NOTEBOOK.stat().st_size < 2_000_000


def test_the_cause_is_named_with_its_numbers(ran):
    folder, _ = ran
    found = json.loads((folder / "out" / "diagnose" / "result.json").read_text("utf-8"))
    assert (found["verdict"], found["effects"]) == ("named", ["sheath_compliance"])
    mount = found["parameters"]["sheath.sheath_compliance"]
    assert mount["low"] < 6e-5 < mount["high"]
    assert found["calibrated"]["sheath.friction"]["value"] == pytest.approx(0.10, abs=0.002)
    assert found["calibrated"]["sheath.pretension"]["value"] == pytest.approx(15.6, abs=0.15)
    assert found["gap"]["held_out"]["reducible_closed"] > 0.95


def test_the_play_of_the_second_rig_is_named_with_its_numbers(ran):
    folder, _ = ran
    found = json.loads((folder / "out" / "wrist" / "result.json").read_text("utf-8"))
    assert (found["verdict"], found["effects"]) == ("named", ["backlash"])
    for name, truth in (("backlash", PLAY), ("friction", FRICTION), ("pretension", PRETENSION)):
        for cable in ("agonist", "antagonist"):
            fitted = {**found["parameters"], **found["calibrated"]}[f"{cable}_sheath.{name}"]
            assert fitted["low"] < truth < fitted["high"]
            assert fitted["value"] == pytest.approx(truth, rel=0.03)


def test_the_page_says_what_its_commands_say_and_its_files_are_shipped(ran):
    folder, printed = ran
    for name in ("rig.xml", "rig.toml"):
        shipped = (example_rig() / name).read_text("utf-8")
        assert (folder / name).read_text("utf-8").strip() == shipped.strip()
    assert (folder / "out" / "check" / "triangles.png").is_file()
    assert "no faults found" in printed
    assert "an elastic mount of the sheath" in printed
    errors = [float(x) for x in re.findall(r"rms error of the lever ([\d.]+) deg", printed)]
    zones = [float(x) for x in re.findall(r"dead zone ([\d.]+) deg", printed)]
    assert errors[1] < 0.2 < 0.9 < errors[0]
    assert zones[1] > zones[0] + 2.0


def test_the_shipped_recordings_say_that_they_are_not_measured():
    for name in ("triangles", "sines"):
        path, toml = example_rig() / f"{name}.csv", example_rig() / "rig.toml"
        assert "made up" in read_recording(path, toml).source
        with pytest.raises(RecordingError, match=r"did you mean|there is"):
            read_recording(path)
