"""The wheel holds the package, its models and the library, and nothing else."""

import re
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest
from packaging.requirements import Requirement

from tendon_mj.native import FOLDER, load

ROOT = Path(__file__).parents[1]


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    """Path in the wheel → text of the file, for all that the clone's wheel holds."""
    folder = tmp_path_factory.mktemp("wheel")
    command = [sys.executable, "-m", "hatchling", "build", "--target", "wheel", "-d", str(folder)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    (path,) = folder.glob("*.whl")
    with zipfile.ZipFile(path) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def files(folder):
    """Path below the parent → content, for every file of a folder but machine code."""
    machine_code = {"__pycache__", FOLDER.name}
    paths = (p for p in folder.rglob("*") if p.is_file() and not machine_code & set(p.parts))
    return {p.relative_to(folder.parent).as_posix(): p.read_bytes() for p in paths}


def test_the_wheel_is_the_package_with_its_models(wheel):
    models = {f"tendon_mj/{name}": content for name, content in files(ROOT / "models").items()}
    expected = files(ROOT / "tendon_mj") | models
    packaged = {name: wheel[name] for name in wheel if ".dist-info/" not in name}
    library = load().path
    assert packaged.pop(f"tendon_mj/native/{FOLDER.name}/{library.name}") == library.read_bytes()
    assert packaged.keys() == expected.keys()
    assert packaged == expected


@pytest.mark.parametrize("python", ["3.11", "3.12", "3.13", "3.14"])
def test_dm_control_comes_with_the_extra_where_labmaze_can_be_installed(wheel, python):
    plain, extra = (required(wheel, python, extra) for extra in ("", "environments"))
    assert plain == {"mujoco", "numpy"}
    assert "dm-env" in extra
    assert "labmaze" not in extra
    assert ("dm-control" in extra) == (python in ("3.11", "3.12"))


def required(wheel, python, extra):
    """Names of the packages that the wheel requires with an extra on a Python."""
    (metadata,) = (text.decode() for name, text in wheel.items() if name.endswith("METADATA"))
    lines = re.findall(r"^Requires-Dist: (.*)$", metadata, re.M)
    here = {"python_version": python, "extra": extra}
    requirements = (Requirement(line) for line in lines)
    return {r.name for r in requirements if r.marker is None or r.marker.evaluate(here)}
