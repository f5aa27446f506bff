"""The studies of sheaths on Warp write what they found."""

import json
import subprocess
import sys

import pytest

WHY = "the extra `warp` is not installed: pip install 'tendon-mj[warp]'"
pytest.importorskip("mujoco_warp", reason=WHY)

from experiments.warp_comparison import warp_comparison  # noqa: E402


def test_the_bench_agrees_to_a_thousandth_of_its_tensions(tmp_path):
    warp_comparison(("bench",), out=tmp_path, duration=0.01, worlds=2, rounds=1)
    (row,) = json.loads((tmp_path / "result.json").read_text())["rows"]
    assert row["model"] == "bench"
    assert 0.0 < row["rms"] <= row["largest"] < 1e-3
    assert row["unsolved"] == 0
    assert row["step"] > 0.0


def test_no_solve_evaluates_much_more_often_than_the_mean(tmp_path):
    command = ["-m", "experiments.warp_evaluations", "bench", "--worlds", "8", "--rounds", "2"]
    # a process of its own, in which the kernels are those that count
    subprocess.run([sys.executable, *command, "--out", str(tmp_path)], check=True)
    (row,) = json.loads((tmp_path / "result.json").read_text())["rows"]
    assert 0 < row["solves"] <= 8 * 20
    assert 16 < row["mean"] < row["most"] < 6 * row["mean"]
