"""A short form of `python -m experiments.soak`: hostile input, and the lives of models."""

import sys

import pytest

from experiments.soak.batches import run_batches
from experiments.soak.killed_runs import whole

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="reads the memory as POSIX has it")


@pytest.mark.parametrize(
    ("name", "trials"),
    [("model_fuzz", 150), ("recording_fuzz", 150), ("command_fuzz", 40), ("life_cycle", 20)],
)
def test_nothing_crashes_and_every_refusal_says_what_and_where(name, trials):
    found = run_batches(f"experiments.soak.{name}", trials, seed=7)
    assert found.trials == trials
    assert not found.crashes
    assert not found.violations
    assert len(found.counts) > 1  # what was drawn was neither all refused nor all taken


def test_a_crash_is_seen():
    found = run_batches("tests.guarantees.dies", 3)
    assert len(found.crashes) == 1
    assert "dies 0 3: status -" in found.crashes[0]


@pytest.mark.parametrize("name", ["result.json", "model.xml", "report.html", "loop.toml"])
def test_half_of_a_file_is_seen(tmp_path, name):
    texts = {".json": '{"a": 1}', ".xml": "<a><b/></a>", ".html": "<html>x</html>"}
    text = texts.get(name[name.index(".") :], 'a = "bcd"')
    (tmp_path / name).write_text(text)
    assert whole(tmp_path / name)
    (tmp_path / name).write_text(text[:-3])
    assert not whole(tmp_path / name)
