"""A suite is solved case by case; one that cannot be read stops no other."""

import json
import shutil

from experiments.hidden_effects.case_folder import solve_suite
from tendon_mj.models import example_recording


def solve(case):
    """Result that a tool could give."""
    return {"verdict": "nothing", "effects": [], "samples": len(case.train[0].time)}


def write_case(folder, model="bench"):
    folder.mkdir(parents=True)
    recording = example_recording()
    for name in ("train_1", "held_out_1"):
        shutil.copy(recording, folder / f"{name}.csv")
        toml = recording.with_suffix(".toml").read_text("utf-8")
        assert 'model = "bench"' in toml
        text = toml.replace('model = "bench"', f'model = "{model}"')
        (folder / f"{name}.toml").write_text(text, "utf-8")
    (folder / "case.json").write_text('{"exclude": []}')


def solved(base, capsys):
    """Names of the cases that a run solves."""
    solve_suite(solve, base / "suite", base / "out", cases=0, again=False, processes=1)
    lines = capsys.readouterr().out.splitlines()
    return {line.partition(": ")[2].split()[0] for line in lines}


def test_cases_that_cannot_be_read_are_told_and_stop_no_other(tmp_path, capsys):
    broken = {
        "table": ("train_1.csv", "time_s\nx\n", "train_1.csv"),
        "half": ("case.json", "{", 'case.json: it is not like {"exclude": []}'),
        "nothing": ("train_1.csv", None, "no train_*.csv"),
    }
    for name in (*broken, "whole"):
        write_case(tmp_path / "suite" / name)
    for name, (file, content, _) in broken.items():
        path = tmp_path / "suite" / name / file
        path.unlink() if content is None else path.write_text(content)
    assert solved(tmp_path, capsys) == {*broken, "whole"}
    for name, (_, _, said) in broken.items():
        told = json.loads((tmp_path / "out" / name / "run.json").read_text("utf-8"))
        assert said in told["error"]
        assert not (tmp_path / "out" / name / "result.json").exists()
    assert json.loads((tmp_path / "out" / "whole" / "result.json").read_text("utf-8"))
    assert solved(tmp_path, capsys) == set()
    (tmp_path / "out" / "whole" / "result.json").write_text("{")  # is computed again
    (tmp_path / "out" / "half" / "run.json").unlink()
    assert solved(tmp_path, capsys) == {"whole", "half"}
