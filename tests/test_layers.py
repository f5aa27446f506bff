"""The rooms of the package: an import goes down only, and every module stays readable."""

import ast
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parents[1] / "tendon_mj"
MODULES = sorted(p for p in PACKAGE.rglob("*.py") if "models" not in p.parts)
# layer of each package, counted from the bottom; packages on one layer do not know each other
LAYERS = {
    "__main__": 10,
    "cli": 9,
    "view": 8,
    "diagnosis": 7,
    "environment": 7,
    "verification": 7,
    "finger": 6,
    "replay": 5,
    "builders": 4,
    "attach": 3,
    "engine": 2,
    "sheath": 1,
    "theory": 1,
    "reference": 1,
    "recordings": 1,
    "progress": 0,
    "errors": 0,
    "compilation": 0,
}
TWINS = {"sheath", "theory", "reference"}


def room_of(path: Path) -> str:
    parts = path.relative_to(PACKAGE).with_suffix("").parts
    return parts[0]


def imported(tree: ast.AST, path: Path) -> set[str]:
    """Full names of all that a module imports, wherever in it."""
    names: set[str] = set()
    package = ["tendon_mj", *path.relative_to(PACKAGE).parent.parts]
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            base = package[: len(package) - node.level + 1] if node.level else []
            start = ".".join([*base, *([node.module] if node.module else [])])
            names |= {f"{start}.{alias.name}" for alias in node.names}
    return names


def rooms_in(names: set[str]) -> set[str]:
    """Rooms that imported names lie in; the package itself stands for every room."""
    found = set()
    for name in names:
        parts = name.split(".")
        if parts[0] == "tendon_mj":
            found.add(parts[1] if len(parts) > 1 else "tendon_mj")
    return found


def trespasses(room: str, names: set[str]) -> list[str]:
    below = {r for r, layer in LAYERS.items() if layer < LAYERS[room]} | {room}
    if room in TWINS:
        below -= TWINS - {room}
    return sorted(rooms_in(names) - below)


def parsed(path: Path) -> ast.Module:
    return ast.parse(path.read_text(encoding="utf-8"))


def named(path: Path) -> str:
    return str(path.relative_to(PACKAGE))


@pytest.mark.parametrize("path", MODULES, ids=named)
def test_imports_go_down_only(path):
    if path == PACKAGE / "__init__.py":
        return  # the door, which shows all of the house
    room = room_of(path)
    assert room in LAYERS, f"{named(path)} is in no known room"
    assert not trespasses(room, imported(parsed(path), path))


def test_a_trespass_is_seen_wherever_it_hides():
    hidden = ast.parse("def f():\n    from tendon_mj.sheath import Law\n    return Law")
    relative = ast.parse("from ..reference import run")
    below = ast.parse("import numpy, tendon_mj.errors\nfrom tendon_mj import errors")
    whole = ast.parse("import tendon_mj")
    path = PACKAGE / "theory" / "play.py"
    assert trespasses("theory", imported(hidden, path)) == ["sheath"]
    assert trespasses("theory", imported(relative, path)) == ["reference"]
    assert trespasses("theory", imported(below, path)) == []
    assert trespasses("theory", imported(whole, path)) == ["tendon_mj"]
    assert trespasses("sheath", {"tendon_mj.theory.play"}) == ["theory"]


ENGINE = ["abi", "sheath_plugin", "servo_plugin"]  # each may import those before it


def test_the_engine_s_packages_import_one_way():
    for path in (PACKAGE / "engine").rglob("*.py"):
        parts = path.relative_to(PACKAGE / "engine").parts
        if parts[0] in ENGINE:
            forbidden = [*ENGINE[ENGINE.index(parts[0]) + 1 :], "instances", "plugin"]
            names = [n.split(".") for n in imported(parsed(path), path)]
            inside = {n[2] for n in names if n[:2] == ["tendon_mj", "engine"] and len(n) > 2}
            assert not inside & set(forbidden), named(path)


def test_outside_the_engine_its_package_alone_is_imported():
    for path in MODULES:
        if path.relative_to(PACKAGE).parts[0] != "engine":
            for node in ast.walk(parsed(path)):
                if isinstance(node, ast.ImportFrom) and node.module:
                    assert not node.module.startswith("tendon_mj.engine."), named(path)


def test_only_the_engine_knows_where_c_keeps_its_fields():
    for path in MODULES:
        outside = {n.split(".")[0] for n in imported(parsed(path), path)}
        inside = {n for n in imported(parsed(path), path) if n.startswith("mujoco.introspect")}
        if room_of(path) != "engine":
            assert not inside, named(path)
            assert not outside & {"ctypes", "cffi", "llvmlite"}, named(path)


@pytest.mark.parametrize("path", MODULES, ids=named)
def test_modules_stay_short_and_say_what_they_do(path):
    assert len(path.read_text(encoding="utf-8").splitlines()) <= 300
    tree = parsed(path)
    if path.stat().st_size:
        assert ast.get_docstring(tree), "the module"
    for node in tree.body:
        if isinstance(node, (ast.FunctionDef, ast.ClassDef)) and not node.name.startswith("_"):
            assert ast.get_docstring(node), node.name
            inner = node.body if isinstance(node, ast.ClassDef) else []
            for method in inner:
                if isinstance(method, ast.FunctionDef) and not method.name.startswith("_"):
                    assert ast.get_docstring(method), method.name
