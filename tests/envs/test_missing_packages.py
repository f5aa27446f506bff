"""Without dm-control and gymnasium all else runs, and the environments say what they need."""

import subprocess
import sys

import pytest

# a package is made impossible to import before anything of the package is
WITHOUT = "import sys; sys.modules[{package!r}] = None\n"
EVERYTHING_ELSE = """
import importlib, pkgutil
import tendon_mj

def names(path, prefix):
    for module in pkgutil.iter_modules(path, prefix):
        if module.name not in ("tendon_mj.envs", "tendon_mj.warp", "tendon_mj.__main__"):
            yield module.name
            if module.ispkg:
                yield from names(importlib.import_module(module.name).__path__, module.name + ".")

for name in names(tendon_mj.__path__, "tendon_mj."):
    importlib.import_module(name)
print(sorted(name for name in sys.modules if name.startswith("tendon_mj.")))
"""
ENVIRONMENTS = """
from tendon_mj.errors import MissingPackageError, TendonError
try:
    from tendon_mj.envs import {name}
except TendonError as error:
    assert isinstance(error, MissingPackageError) and isinstance(error, ImportError)
    print(error, error.name, sep="|")
"""


def run(script):
    command = [sys.executable, "-W", "error", "-c", script]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


def test_everything_but_the_environments_runs_without_dm_control():
    imported = run(WITHOUT.format(package="dm_control") + EVERYTHING_ELSE)
    for module in (
        "tendon_mj.cli.commands",
        "tendon_mj.lab.finger",
        "tendon_mj.lab.diagnosis.diagnose",
    ):
        assert f"'{module}'" in imported


@pytest.mark.parametrize("package", ["dm_control", "dm_env"])
def test_the_environments_say_what_is_missing_and_how_to_install_it(package):
    asked = ENVIRONMENTS.format(name="hold_force")
    sentence, name = run(WITHOUT.format(package=package) + asked).split("|")
    assert name == package
    assert f"needs {package}, which is not installed" in sentence
    assert "pip install 'tendon-mj[environments]'" in sentence
    assert "pip install --no-deps dm-control" in sentence


def test_without_gymnasium_its_environments_say_so_in_a_line():
    asked = ENVIRONMENTS.format(name="HoldForceEnv")
    sentence, name = run(WITHOUT.format(package="gymnasium") + asked).split("|")
    assert name == "gymnasium"
    assert sentence == (
        "tendon_mj.envs.HoldForceEnv needs gymnasium, which is not installed: "
        "pip install 'tendon-mj[gymnasium]'"
    )


@pytest.mark.parametrize(
    ("package", "name"), [("dm_control", "HoldForceEnv"), ("gymnasium", "hold_force")]
)
def test_each_kind_of_environment_needs_its_own_package_only(package, name):
    assert run(WITHOUT.format(package=package) + ENVIRONMENTS.format(name=name)) == ""


def test_the_package_alone_imports_no_gymnasium():
    assert run("import sys, tendon_mj; print('gymnasium' in sys.modules)") == "False"
