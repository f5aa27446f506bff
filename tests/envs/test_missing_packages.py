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
        if module.name.removeprefix("tendon_mj.") not in ("envs", "warp", "mjlab", "__main__"):
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


@pytest.mark.parametrize(
    ("module", "package", "extra"),
    [("show", "scipy", "lab"), ("envs", "scipy", "lab"), ("mjlab", "mjlab", "mjlab")],
)
def test_a_package_names_what_it_needs_and_the_extra_that_has_it(module, package, extra):
    script = f"""
try:
    import tendon_mj.{module}
except ModuleNotFoundError as error:
    print(error, error.name, sep="|")
"""
    sentence, name = run(WITHOUT.format(package=package) + script).split("|")
    assert name == package
    assert f"pip install 'tendon-mj[{extra}]'" in sentence


def test_everything_but_the_environments_runs_without_dm_control():
    imported = run(WITHOUT.format(package="dm_control") + EVERYTHING_ELSE)
    for module in ("tendon_mj.cli", "tendon_mj.lab.finger", "tendon_mj.lab.diagnosis"):
        assert f"'{module}'" in imported


@pytest.mark.parametrize(
    ("package", "needing", "other", "extra"),
    [
        ("dm_control", "hold_force", "HoldForceEnv", "environments"),
        ("gymnasium", "HoldForceEnv", "hold_force", "gymnasium"),
    ],
)
def test_an_environment_needs_its_own_package_only_and_names_its_installation(
    package, needing, other, extra
):
    tried = [ENVIRONMENTS.format(name=name) for name in (needing, other)]
    sentence, name = run(WITHOUT.format(package=package) + "".join(tried)).split("|")
    assert name == package
    assert f"tendon_mj.envs.{needing} needs {package}" in sentence
    assert f"pip install 'tendon-mj[{extra}]'" in sentence


def test_the_package_alone_imports_no_gymnasium():
    assert run("import sys, tendon_mj; print('gymnasium' in sys.modules)") == "False"
