"""Commands of experiments refuse in one line, before anything is computed or written."""

import pytest

from experiments.cable_tool.__main__ import cable_tool
from experiments.command import run_experiment
from experiments.force_servo.__main__ import force_servo
from experiments.kaneko1991.__main__ import kaneko1991
from experiments.measured_joint.__main__ import measured_joint
from experiments.positioning_system.__main__ import positioning_system

MEASURED = (cable_tool, measured_joint, positioning_system)  # from data that are not here


@pytest.mark.parametrize(
    ("tool", "out", "options", "data", "said"),
    [
        *((tool, "out", [], None, "set TENDON_MJ_DATA") for tool in MEASURED),
        *((tool, "out", [], ".", "holds no CSV file") for tool in MEASURED[:2]),
        (kaneko1991, "out", ["--histories", "-1"], None, "histories = -1 must be ≥ 0"),
        *((tool, "file", [], None, "--out ") for tool in (kaneko1991, force_servo)),
    ],
)
def test_what_cannot_be_computed_is_refused(
    tool, out, options, data, said, tmp_path, monkeypatch, capsys
):
    monkeypatch.delenv("TENDON_MJ_DATA", raising=False)
    if data:
        monkeypatch.setenv("TENDON_MJ_DATA", str(tmp_path))
    (tmp_path / "file").write_text("")
    name = tool.__name__
    assert run_experiment(tool, name, ["--out", str(tmp_path / out), *options]) == 2
    error = capsys.readouterr().err
    assert error.startswith(f"python -m experiments.{name}: ")
    assert said in error
    assert error.count("\n") == 1
    assert [path.name for path in tmp_path.iterdir()] == ["file"]
