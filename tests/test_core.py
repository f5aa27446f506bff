"""The core runs with mujoco and NumPy alone; all else names the extra that it needs."""

import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
from packaging.requirements import Requirement

from tests.test_snippets import FINGER

ROOT = Path(__file__).parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
MODULES = {"imageio-ffmpeg": "imageio_ffmpeg", "pillow": "PIL", "tomli-w": "tomli_w"}
CORE = """
import sys
for package in [*{blocked}, "numba", "llvmlite"]:
    sys.modules[package] = None
import tendon_mj, tendon_mj.attach, tendon_mj.plugin, tendon_mj.sheath, tendon_mj.theory
from tendon_mj.models import build_bench, load_model
load_model("finger")
"""
LAZY = """
from tendon_mj.errors import MissingPackageError
try:
    tendon_mj.{name}
except MissingPackageError as error:
    assert isinstance(error, ImportError) and isinstance(error, tendon_mj.TendonError)
    print(error.name, error, sep="|")
"""


def names(requirements):
    return {Requirement(line).name for line in requirements}


LAB = {MODULES.get(name, name) for name in names(PROJECT["optional-dependencies"]["lab"])}


def run(code, folder=None):
    command = [sys.executable, "-W", "error", "-c", CORE.format(blocked=sorted(LAB)) + code]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)


def test_the_first_snippets_of_the_readme_run_without_the_laboratory(tmp_path):
    snippets = re.findall(r"```python\n(.*?)```", (ROOT / "README.md").read_text("utf-8"), re.S)
    (tmp_path / "hand.xml").write_text(FINGER.format(""))
    done = run("\n".join(snippets[:2]), tmp_path)
    assert done.returncode == 0, done.stderr
    assert "[" in done.stdout  # the tensions of the second


@pytest.mark.parametrize("name", ["diagnose", "read_recording", "Simulator", "render_clip"])
def test_a_name_of_the_laboratory_says_what_is_missing_and_how_to_install_it(name):
    done = run(LAZY.format(name=name))
    assert done.returncode == 0, done.stderr
    package, sentence = done.stdout.strip().split("|")
    assert package in LAB
    assert sentence == (
        f"tendon_mj.{name} needs {package}, which is not installed: pip install 'tendon-mj[lab]'"
    )


def test_the_command_line_says_so_in_a_line():
    done = run("from tendon_mj.__main__ import main; sys.exit(main())")
    assert done.returncode == 2
    assert done.stderr.startswith("tendon-mj: the command")
    assert done.stderr.endswith("pip install 'tendon-mj[lab]'\n")
    assert done.stderr.count("\n") == 1
