"""Layers of the package: imports go down only, without cycles; every module says what it does."""

import ast
import importlib
import re
from collections import Counter
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parents[1] / "tendon_mj"
MODULES = sorted(p for p in PACKAGE.rglob("*.py") if "models" not in p.parts)
# layer of each package, counted from the bottom; packages of one layer do not import each other
LAYERS = {
    "__main__": 11,
    "cli": 10,
    "environment": 10,
    "view": 9,
    "live": 9,
    "fleet": 8,
    "next_experiment": 8,
    "diagnosis": 7,
    "verification": 7,
    "sweep": 7,
    "finger": 6,
    "data_check": 6,
    "replay": 5,
    "builders": 4,
    "attach": 3,
    "warp": 3,
    "engine": 2,
    "abi": 1,
    "sheath": 1,
    "theory": 1,
    "reference": 1,
    "recordings": 1,
    "tasks": 1,
    "progress": 0,
    "errors": 0,
    "interruption": 0,
    "whole_file": 0,
    "model_files": 1,
    "compilation": 0,
}
INDEPENDENT = {"sheath", "theory", "reference"}  # their agreement is evidence
MOST_MODULES = 20  # in a folder
LARGEST_SHARE = 0.20  # of a package, of all lines


def parsed(path):
    return ast.parse(path.read_text(encoding="utf-8"))


def relative(path):
    return str(path.relative_to(PACKAGE))


def package_of(path):
    """The package directly under tendon_mj that a module belongs to."""
    return path.relative_to(PACKAGE).with_suffix("").parts[0]


def module_name(path):
    """Dotted name of a module; that of a package for its __init__.py."""
    parts = ("tendon_mj", *path.relative_to(PACKAGE).with_suffix("").parts)
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def imported(tree, path):
    """Full names of all that a module imports, wherever in it."""
    names = set()
    package = ["tendon_mj", *path.relative_to(PACKAGE).parent.parts]
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            base = package[: len(package) - node.level + 1] if node.level else []
            start = ".".join([*base, *([node.module] if node.module else [])])
            names |= {f"{start}.{alias.name}" for alias in node.names}
    return names


def packages_in(names):
    """Packages that imported names lie in; tendon_mj itself stands for all of them."""
    found = set()
    for name in names:
        parts = name.split(".")
        if parts[0] == "tendon_mj":
            found.add(parts[1] if len(parts) > 1 else "tendon_mj")
    return found


def layering_violations(package, names):
    """Packages among imported names that ``package`` may not import."""
    below = {other for other, layer in LAYERS.items() if layer < LAYERS[package]} | {package}
    if package in INDEPENDENT:
        below -= INDEPENDENT - {package}
    return sorted(packages_in(names) - below)


def import_graph(sources):
    """Module → modules that it imports, of a mapping from module to the names it imports.

    A name that is not a module belongs to the longest prefix that is one.
    """
    graph = {}
    for module, names in sources.items():
        found = set()
        for name in names:
            parts = name.split(".")
            prefixes = [".".join(parts[:k]) for k in range(len(parts), 0, -1)]
            found.add(next((prefix for prefix in prefixes if prefix in sources), module))
        graph[module] = found - {module}
    return graph


def grouped(graph, parent):
    """Graph among the direct children of a package: its subpackages and its own modules."""

    def child(module):
        inner = module.removeprefix(f"{parent}.")
        return inner.split(".")[0] if inner != module else None

    children = {}
    for module, targets in graph.items():
        if child(module):
            found = children.setdefault(child(module), set())
            found |= {child(target) for target in targets} - {child(module), None}
    return children


def cycle(graph):
    """Names along a cycle, the first repeated at the end; empty without one."""
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        return error.args[1]
    return []


GRAPH = import_graph({module_name(path): imported(parsed(path), path) for path in MODULES})
PARENTS = sorted({module_name(p) for p in MODULES if p.name == "__init__.py"} - {"tendon_mj"})


@pytest.mark.parametrize("path", MODULES, ids=relative)
def test_imports_go_down_only(path):
    if path == PACKAGE / "__init__.py":
        return  # the public face, which shows all packages
    package = package_of(path)
    assert package in LAYERS, f"{relative(path)} is in no known package"
    assert not layering_violations(package, imported(parsed(path), path))


def test_a_violation_is_seen_wherever_it_hides():
    hidden = ast.parse("def f():\n    from tendon_mj.sheath import Law\n    return Law")
    by_dots = ast.parse("from ..reference import run")
    below = ast.parse("import numpy, tendon_mj.errors\nfrom tendon_mj import errors")
    whole = ast.parse("import tendon_mj")
    path = PACKAGE / "theory" / "play.py"
    assert layering_violations("theory", imported(hidden, path)) == ["sheath"]
    assert layering_violations("theory", imported(by_dots, path)) == ["reference"]
    assert layering_violations("theory", imported(below, path)) == []
    assert layering_violations("theory", imported(whole, path)) == ["tendon_mj"]
    assert layering_violations("sheath", {"tendon_mj.theory.play_operator"}) == ["theory"]


def test_no_modules_import_each_other_in_a_cycle():
    assert not cycle(GRAPH), " → ".join(cycle(GRAPH))


@pytest.mark.parametrize("parent", PARENTS)
def test_no_subpackages_or_modules_of_a_package_form_a_cycle(parent):
    found = cycle(grouped(GRAPH, parent))
    assert not found, f"within {parent}: {' → '.join(found)}"


def test_a_cycle_is_seen_between_modules_and_between_subpackages():
    sources = {
        "p": set(),
        "p.low": set(),
        "p.low.a": {"numpy.array"},
        "p.low.b": {"p.high.d.f"},
        "p.high": set(),
        "p.high.c": {"p.low.a.name"},
        "p.high.d": set(),
    }
    graph = import_graph(sources)
    assert graph["p.high.c"] == {"p.low.a"}
    assert not cycle(graph)
    assert set(cycle(grouped(graph, "p"))) == {"low", "high"}
    assert set(cycle({"one": {"two"}, "two": {"one"}})) == {"one", "two"}


ENGINE = ["abi", "sheath_plugin", "servo_plugin"]  # each may import those before it


def test_the_engine_s_packages_import_one_way():
    for path in (PACKAGE / "engine").rglob("*.py"):
        parts = path.relative_to(PACKAGE / "engine").parts
        if parts[0] in ENGINE:
            forbidden = [*ENGINE[ENGINE.index(parts[0]) + 1 :], "instances", "plugin"]
            names = [n.split(".") for n in imported(parsed(path), path)]
            inside = {n[2] for n in names if n[:2] == ["tendon_mj", "engine"] and len(n) > 2}
            assert not inside & set(forbidden), relative(path)


def test_outside_the_engine_its_package_alone_is_imported():
    for path in MODULES:
        if path.relative_to(PACKAGE).parts[0] != "engine":
            for node in ast.walk(parsed(path)):
                if isinstance(node, ast.ImportFrom) and node.module:
                    assert not node.module.startswith("tendon_mj.engine."), relative(path)


def test_only_the_abi_and_the_engine_know_where_c_keeps_its_fields():
    for path in MODULES:
        outside = {n.split(".")[0] for n in imported(parsed(path), path)}
        inside = {n for n in imported(parsed(path), path) if n.startswith("mujoco.introspect")}
        if package_of(path) not in {"abi", "engine"}:
            assert not inside, relative(path)
            assert not outside & {"ctypes", "cffi"}, relative(path)
            assert "llvmlite" not in outside or package_of(path) == "compilation", relative(path)


# what views may take from the package: formats of data, closed forms, and results that others made
SHOWN = {
    "tendon_mj.errors",
    "tendon_mj.progress",
    "tendon_mj.recordings",
    "tendon_mj.theory",
    "tendon_mj.view",
    "tendon_mj.whole_file",
    "tendon_mj.builders.bench.Bench",
    "tendon_mj.builders.finger_parameters",
    "tendon_mj.builders.finger_shapes.TENDON_COLOUR",
    "tendon_mj.engine.sheaths",
    "tendon_mj.replay.frames.Array",
    "tendon_mj.replay.frames.Cable",
    "tendon_mj.replay.frames.Frames",
    "tendon_mj.replay.frames.POSE",
    "tendon_mj.replay.misfit",
    "tendon_mj.replay.engineering_units",
    "tendon_mj.replay.units",
    "tendon_mj.sweep.influence",
    "tendon_mj.fleet.result",
    "tendon_mj.verification.first_motion.BenchReadings",
    "tendon_mj.verification.first_motion.FirstMotion",
    "tendon_mj.diagnosis.BeforeAfter",
    "tendon_mj.diagnosis.Bin",
    "tendon_mj.diagnosis.Diagnosis",
    "tendon_mj.diagnosis.ErrorReduction",
    "tendon_mj.diagnosis.Finding",
    "tendon_mj.diagnosis.Located",
    "tendon_mj.diagnosis.SysidResult",
    "tendon_mj.diagnosis.Value",
    "tendon_mj.diagnosis.before_after.BeforeAfter",
    "tendon_mj.diagnosis.correlations",
    "tendon_mj.diagnosis.effects.discrimination",
    "tendon_mj.diagnosis.effects.effect",
    "tendon_mj.diagnosis.noise_sensitivity",
    "tendon_mj.diagnosis.provenance",
    "tendon_mj.diagnosis.result.diagnosis.Diagnosis",
    "tendon_mj.diagnosis.result.diagnosis.Verdict",
    "tendon_mj.diagnosis.sysid.SysidResult",
    "tendon_mj.diagnosis.whiteness",
}
POSES = {"mj_setState", "mj_stateSize", "mj_fwdPosition"}  # MuJoCo's, on a state that was recorded
STEPS = re.compile(r"mj_\w+|[Rr]ollout|simulate")  # the last is a method of a diagnosis


def shown(name):
    """Whether an imported name is one of SHOWN, or inside one."""
    return any(name == one or name.startswith(f"{one}.") for one in SHOWN)


def stepping(tree, path):
    """Names in a view by which it could step a simulation, called there or handed on."""
    names = imported(tree, path)
    outside = {n for n in names if n.split(".")[0] == "tendon_mj" and not shown(n)}
    outside |= {n for n in names if n.split(".")[0] == "mujoco" and n != "mujoco"}
    used = {node.attr for node in ast.walk(tree) if isinstance(node, ast.Attribute)}
    return outside | {name for name in used - POSES if STEPS.fullmatch(name)}


def calls(tree):
    """Names of all functions and methods that are called."""
    called = (node.func for node in ast.walk(tree) if isinstance(node, ast.Call))
    return {f.attr if isinstance(f, ast.Attribute) else getattr(f, "id", "") for f in called}


def modules_of(package):
    return [path for path in MODULES if package_of(path) == package]


@pytest.mark.parametrize("path", modules_of("view"), ids=relative)
def test_views_step_no_simulation(path):
    assert not stepping(parsed(path), path)


@pytest.mark.parametrize(
    ("code", "found"),
    [
        ("import mujoco\nmujoco.mj_step(m, d)", "mj_step"),
        ("import mujoco\nadvance = mujoco.mj_step2", "mj_step2"),
        ("from mujoco import mj_forward as now", "mujoco.mj_forward"),
        ("from mujoco.rollout import Rollout", "mujoco.rollout.Rollout"),
        ("import mujoco.rollout", "mujoco.rollout"),
        ("found.simulate()", "simulate"),
        ("import tendon_mj", "tendon_mj"),
        ("from tendon_mj import replay", "tendon_mj.replay"),
        ("from tendon_mj import replay_recording", "tendon_mj.replay_recording"),
        ("from ...replay import replay_recording", "tendon_mj.replay.replay_recording"),
        ("from tendon_mj.replay.frames import *", "tendon_mj.replay.frames.*"),
        ("import tendon_mj.replay.rollout", "tendon_mj.replay.rollout"),
        ("from tendon_mj.environment import hold_force", "tendon_mj.environment.hold_force"),
    ],
)
def test_a_view_that_steps_is_seen(code, found):
    assert stepping(ast.parse(code), PACKAGE / "view" / "figures" / "loops.py") == {found}


@pytest.mark.parametrize(
    "name",
    [
        "replay.replay_recording.replay_recording",
        "replay.rollout.rollout_sensors",
        "replay.rollout.rollout_named_sensors",
        "replay.open_loop.run_open_loop",
        "replay.simulator.Simulator",
        "replay.frames.record_frames",
        "replay.frames.FrameRecorder",
        "finger.control.prepare_finger",
        "finger.control.simulate_finger",
        "verification.first_motion.sweep",
        "verification.rollout_speedup.rollout_speedup",
        "verification.benchmark.benchmark.run_benchmark",
        "sheath.drive_tension",
        "diagnosis.diagnose",
        "diagnosis.fit_with_sysid",
    ],
)
def test_no_view_may_import_what_steps(name):
    package, _, last = f"tendon_mj.{name}".rpartition(".")
    assert callable(getattr(importlib.import_module(package), last))  # else it proves nothing
    tree = ast.parse(f"def f():\n    from {package} import {last}\n    return {last}")
    assert stepping(tree, PACKAGE / "view" / "figures" / "loops.py") == {f"{package}.{last}"}


def test_views_take_everything_that_they_may():
    taken = {name for path in modules_of("view") for name in imported(parsed(path), path)}
    idle = {one for one in SHOWN if not any(n == one or n.startswith(f"{one}.") for n in taken)}
    assert not idle, "take it off SHOWN"


@pytest.mark.parametrize(
    "path", [p for p in MODULES if package_of(p) == "cli"], ids=lambda p: p.stem
)
def test_commands_compute_nothing_themselves(path):
    names = imported(parsed(path), path)
    assert not {n for n in names if n.split(".")[0] in ("numpy", "scipy", "numba")}
    assert not {name for name in calls(parsed(path)) if re.fullmatch(r"mj_\w+|[Rr]ollout", name)}


@pytest.mark.parametrize("path", MODULES, ids=relative)
def test_modules_say_what_they_do(path):
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


def test_no_folder_is_a_long_list_of_modules():
    counts = Counter(path.parent for path in MODULES if path.name != "__init__.py")
    crowded = {relative(folder): count for folder, count in counts.items() if count > MOST_MODULES}
    assert not crowded, f"more than {MOST_MODULES} modules in one folder: {crowded}"


def test_no_package_is_most_of_the_code():
    lines = Counter()
    for path in MODULES:
        lines[package_of(path)] += len(path.read_text(encoding="utf-8").splitlines())
    package, most = lines.most_common(1)[0]
    share = most / lines.total()
    assert share <= LARGEST_SHARE, (
        f"{package} has {most} of {lines.total()} lines, {share:.1%}; at most {LARGEST_SHARE:.0%}"
    )
