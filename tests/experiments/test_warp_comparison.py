"""The study that holds sheaths on Warp against the plugin's writes what it found."""

import json

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
