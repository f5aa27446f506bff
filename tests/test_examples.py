"""Every example runs as it is copied, is a page long, and says what it found."""

import ast
import re
import subprocess
import sys
from pathlib import Path

import pytest

import tendon_mj

EXAMPLES = sorted((Path(__file__).parents[1] / "examples").glob("*.py"))
PAGE = 65  # lines
# what each says, beside finishing: numbers that a reader can check
FOUND = {
    "add_friction": r"friction 0\.15: of a pull of 10 N +7\.73 N arrive at the joint.* deg",
    "diagnose_recordings": r"decided: missing: play.*(?s:.)*sheath\.backlash = .* m, 95 % within",
    "friction_in_mjlab": r"friction \[0\.\d+ .*\nmore bend \[0\.\d+ .*\nof 10 N arrive \[\d\.\d+",
    "press_with_gymnasium": r"random (0\.0\d+), scripted (0\.9\d+)",
    "servo_in_the_step": r"servo on the output tension: 30 N .* (30\.0|29\.9)\d N are reached",
    "sweep_friction": r"0\.15: T_out/T_in from 0\.624 to 1\.602, .* equation 0\.624 to 1\.602",
    "train_to_press": r"after 122880 steps: 0\.[89]\d",
    "train_on_warp": r"unseen frictions: 1\d\.\d deg before, 0\.\d after",
}
NEEDS = {  # what not every environment has
    "friction_in_mjlab": "mjlab",
    "train_on_warp": "mujoco_warp",
    "train_to_press": "stable_baselines3",
}


def run(path, folder):
    """What an example prints in a folder of its own; warnings are errors, but mjlab's own."""
    of_mjlab = "ignore:`torch.jit.script` is deprecated"  # in a class that differs by release
    command = [sys.executable, "-W", "error", "-W", of_mjlab, str(path)]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda p: p.stem)
def test_the_example_runs_and_says_what_it_found(path, tmp_path):
    if path.stem in NEEDS:
        pytest.importorskip(NEEDS[path.stem])
    said = run(path, tmp_path)
    assert re.search(FOUND[path.stem], said), said
    for name in re.findall(r"^wrote (\S+\.png)", said, re.M):
        assert (tmp_path / name).stat().st_size > 10_000


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda p: p.stem)
def test_the_example_is_a_page_of_public_names(path):
    text = path.read_text("utf-8")
    assert len(text.splitlines()) <= PAGE
    tree = ast.parse(text)
    assert ast.get_docstring(tree)
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("tendon_mj"):
            assert node.module == "tendon_mj"
            assert {alias.name for alias in node.names} <= set(tendon_mj.__all__)
