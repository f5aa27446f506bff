"""Experiments import names of `tendon_mj` and of the faces of its packages, no inner modules."""

import ast
import importlib
import inspect
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
FILES = sorted((ROOT / "experiments").rglob("*.py"))


def is_module(package, name):
    """Whether a name of a package is a module, not what the package re-exports under that name."""
    return inspect.ismodule(getattr(importlib.import_module(package), name, None))


def imported_modules(tree):
    """Names of all modules that are imported, wherever in the tree."""
    modules = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            modules |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            modules.add(node.module or ".")
            if str(node.module).split(".")[0] == "tendon_mj":
                names = [alias.name for alias in node.names]
                modules |= {f"{node.module}.{n}" for n in names if is_module(node.module, n)}
    return modules


def inner_modules(tree):
    """Modules of `tendon_mj` that lie deeper than a face: `tendon_mj.X` or `tendon_mj.lab.X`."""
    return sorted(
        name
        for name in imported_modules(tree)
        if name.split(".")[0] == "tendon_mj"
        and name.replace("tendon_mj.lab.", "tendon_mj.", 1).count(".") > 1
    )


@pytest.mark.parametrize("path", FILES, ids=lambda p: str(p.relative_to(ROOT)))
def test_an_experiment_imports_no_inner_module(path):
    tree = ast.parse(path.read_text(encoding="utf-8"))
    assert not inner_modules(tree)
    assert not any(isinstance(node, ast.ImportFrom) and node.level for node in ast.walk(tree)), (
        "imports are absolute"
    )


@pytest.mark.parametrize(
    ("code", "inner"),
    [
        ("from tendon_mj.models.bench import Bench", ["tendon_mj.models.bench"]),
        ("def f():\n    import tendon_mj.show.figures.style", ["tendon_mj.show.figures.style"]),
        ("from tendon_mj.show import figures", ["tendon_mj.show.figures"]),
        ("import tendon_mj.lab.replay.motion", ["tendon_mj.lab.replay.motion"]),
        ("from tendon_mj.models import Bench", []),
        ("from tendon_mj.lab.replay import Drive", []),
        ("from tendon_mj import add_friction, theory", []),
        ("import tendon_mj.errors", []),
    ],
)
def test_an_inner_module_is_seen_wherever_it_hides(code, inner):
    assert inner_modules(ast.parse(code)) == inner
