"""Stages of the diagnosis: an import goes down only, and never in a circle."""

from __future__ import annotations

import ast
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

import tendon_mj.diagnosis

PACKAGE = Path(tendon_mj.diagnosis.__file__).parent
NAME = "tendon_mj.diagnosis"
LAYERS = (
    {"__init__"},
    {"diagnose"},
    {"prove", "sysid", "check"},
    {"result"},
    {"model_selection"},
    {"locate"},
    {"data"},
    {"effects", "effect", "place", "catalogue"},
)
MODULES = {".".join(p.relative_to(PACKAGE).with_suffix("").parts): p for p in PACKAGE.rglob("*.py")}


def imports(module: str) -> set[str]:
    """Modules of the diagnosis that one of them imports."""
    names = set()
    for node in ast.walk(ast.parse(MODULES[module].read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith(NAME):
            source = (node.module or "").removeprefix(NAME).removeprefix(".")
            inner = {".".join(filter(None, (source, alias.name))) for alias in node.names}
            package = ".".join(filter(None, (source, "__init__")))
            names |= inner & MODULES.keys() or {source if source in MODULES else package}
    return names


def layer(module: str) -> int:
    return next(k for k, names in enumerate(LAYERS) if module.split(".")[0] in names)


@pytest.mark.parametrize("module", MODULES)
def test_imports_go_down_only(module: str) -> None:
    for other in imports(module):
        same_package = (
            module.split(".")[0] == other.split(".")[0] or layer(module) == layer(other) == 7
        )
        assert layer(other) > layer(module) or same_package, other


def test_there_is_no_import_circle() -> None:
    TopologicalSorter({module: imports(module) for module in MODULES}).prepare()


def test_the_largest_folder_is_small() -> None:
    folders = {p.parent for p in MODULES.values() if p.parent.name != "effects"}
    assert all(len(list(folder.glob("*.py"))) <= 20 for folder in folders)
