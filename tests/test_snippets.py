"""Every snippet of the README and the docs runs as it is pasted."""

import json
import re
from functools import partial
from pathlib import Path

import mujoco
import numpy as np
import pytest

import tendon_mj

ROOT = Path(__file__).parents[1]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
FINGER = """
<mujoco>
  <worldbody>
    <site name="a"/><site name="b" pos="0.1 0 0"/>
    <body pos="0.2 0 0">
      <joint name="knuckle" axis="0 0 1" stiffness="0.1"/>
      <geom size="0.01" pos="0.05 0 0"/><site name="c" pos="0.03 0.01 0"/>
    </body>
  </worldbody>
  <tendon>
    <spatial name="flexor" stiffness="2000" springlength="0.22">
      <site site="a"/><site site="b"/><site site="c"/>
    </spatial>
  </tendon>
  {}
</mujoco>
"""


def blocks(language):
    # these pages are one example each, which tests/lab/recordings/test_recording.py,
    # tests/test_your_rig.py and a test below run
    whole = ("recording.md", "your_rig.md", "no_tendons.md")
    for page in (p for p in PAGES if p.name not in whole):
        found = re.findall(rf"```{language}\n(.*?)```", page.read_text("utf-8"), re.S)
        for k, code in enumerate(found):
            yield pytest.param(code, id=f"{page.name}-{k}")


def write_results(folder):
    """The hand with friction, and a diagnosis of it, as `tendon-mj` writes them."""
    spec = tendon_mj.add_friction(
        mujoco.MjSpec.from_file("hand.xml"), "flexor", friction=0.2, spring="cable"
    )
    (folder / "hand_with_friction.xml").write_text(spec.to_xml())
    out = folder / "out" / "diagnose"
    out.mkdir(parents=True)
    (out / "model.xml").write_text(spec.to_xml())
    number = {"low": 0.1, "high": 0.2, "unit": "-", "determined": True}
    found = {"proven": True, "parameters": {"knuckle.stiffness": number}, "sessions": {}}
    found["calibrated"] = {"flexor_sheath.friction": number}
    (out / "result.json").write_text(json.dumps(found))


@pytest.mark.filterwarnings("ignore:.*actuatorfrcrange of joint")  # which Newton sets
@pytest.mark.filterwarnings("ignore:add_friction. friction has no effect")  # on two of myohand
@pytest.mark.parametrize("code", list(blocks("python")))
def test_python_snippet_runs(code, tmp_path, monkeypatch, capsys):
    if "mujoco_warp" in code or "tendon_mj.warp" in code:
        pytest.importorskip("mujoco_warp", reason="the extra `warp` is not installed")
    for package in ("gymnasium", "dm_control", "newton", "mjlab", "myosuite"):
        if package in code:
            pytest.importorskip(package, reason="not installed")
    if "tendon_mj.view(" in code:
        pytest.importorskip("mjviser", reason="the extra `web` is not installed")
        brief = partial(tendon_mj.view, seconds=0.1, port=0)
        monkeypatch.setattr(tendon_mj, "view", brief)
    (tmp_path / "hand.xml").write_text(FINGER.format(""))
    motor = '<actuator><motor tendon="flexor" ctrlrange="-9 0"/></actuator>'
    (tmp_path / "hand_with_motor.xml").write_text(FINGER.format(motor))
    monkeypatch.chdir(tmp_path)
    if "with_friction.xml" in code or "out/diagnose" in code:
        write_results(tmp_path)
    names = {}
    exec(compile(code, "snippet", "exec"), names)  # our own documentation, not input
    if "model" in names:
        assert mujoco.MjData(names["model"]).plugin_state.size > 0


@pytest.mark.parametrize("code", list(blocks("xml")))
def test_xml_snippet_loads(code):
    text = FINGER.replace(' stiffness="2000"', "")
    extension = next(b.values[0] for b in blocks("xml") if "<extension>" in b.values[0])
    parts = code if code == extension else extension + code
    assert mujoco.MjModel.from_xml_string(text.format(parts)).nplugin > 0


HAND = """
<mujoco>
  <worldbody>
    <site name="motor" pos="-0.1 0 0"/><site name="a"/><site name="b" pos="0.05 0 0.05"/>
    <site name="c" pos="0.05 0 0.1"/><site name="d" pos="0 0 0.15"/>
    <body pos="-0.1 0 0.15">
      <joint name="fingertip" type="slide" axis="1 0 0" stiffness="1000" damping="20"/>
      <geom size="0.01"/><site name="tip"/>
    </body>
  </worldbody>
  <tendon>
    <spatial name="flexor">
      <site site="motor"/><site site="a"/><site site="b"/><site site="c"/><site site="d"/>
      <site site="tip"/>
    </spatial>
  </tendon>
  <actuator><motor tendon="flexor"/></actuator>
</mujoco>
"""


def readme_code(word):
    readme = (ROOT / "README.md").read_text("utf-8")
    return next(c for c in re.findall(r"```python\n(.*?)```", readme, re.S) if word in c)


def test_the_readme_prints_what_it_shows(tmp_path, monkeypatch, capsys):
    """On a tendon that is drawn back by half a turn."""
    (tmp_path / "hand.xml").write_text(HAND)
    monkeypatch.chdir(tmp_path)
    exec(compile(readme_code("hand.xml"), "snippet", "exec"), {})
    shown = re.search(r"```text\n(.*?)```", (ROOT / "README.md").read_text("utf-8"), re.S)
    assert capsys.readouterr().out == shown[1]


def test_the_page_on_hands_without_tendons_prints_what_it_shows(capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    page = (ROOT / "docs/no_tendons.md").read_text("utf-8")
    blocks = (re.findall(rf"```{word}\n(.*?)```", page, re.S) for word in ("python", "text"))
    names = {}
    for code, shown in zip(*blocks, strict=True):
        exec(compile(code, "snippet", "exec"), names)
        assert capsys.readouterr().out == shown


def test_the_readme_loses_the_tension_that_it_says(capsys):
    exec(compile(readme_code("arc_points"), "snippet", "exec"), {})
    tension = [float(x) for x in re.findall(r"\[([\d.]+)\]", capsys.readouterr().out)]
    assert tension[1] / tension[0] == pytest.approx(np.exp(-0.15 * np.pi), rel=1e-6)
    assert 1 - tension[1] / tension[0] == pytest.approx(1 / 3, abs=0.05)
