"""The public interface: flat names of the package, and nothing else in README and docs."""

import ast
import re
import subprocess
import sys
from importlib.metadata import version
from pathlib import Path

import pytest

import tendon_mj

ROOT = Path(__file__).parents[1]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
# packages that need an extra, and have a page of their own
APART = {"tendon_mj.envs", "tendon_mj.mjlab", "tendon_mj.warp"}


def test_a_star_import_brings_the_public_names_and_no_others():
    names: dict[str, object] = {}
    exec("from tendon_mj import *", names)  # no other way to have it in a function
    assert names.keys() - {"__builtins__"} == set(tendon_mj.__all__) <= set(dir(tendon_mj))
    assert all(names[name] is not None for name in tendon_mj.__all__)
    assert tendon_mj.__version__ == version("tendon-mj")
    with pytest.raises(AttributeError, match="no attribute 'add_frictions'"):
        tendon_mj.add_frictions  # noqa: B018


@pytest.mark.parametrize(
    ("module", "heavy"),
    [
        (
            "tendon_mj",
            "numba llvmlite scipy.linalg scipy.optimize matplotlib dm_control PIL jinja2 mjlab",
        ),
        ("tendon_mj.cli.diagnose", "numba llvmlite scipy.optimize scipy.signal scipy.stats plotly"),
    ],
)
def test_the_import_is_light(module, heavy):
    code = f"import sys, {module}; print(*sys.modules)"
    shown = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert not set(heavy.split()) & set(shown.stdout.split())


def imported_names(code):
    """(module, name) of all that a snippet imports of this package."""
    for node in ast.walk(ast.parse(code)):
        if isinstance(node, ast.Import):
            for alias in node.names:
                if alias.name.split(".")[0] == "tendon_mj":
                    yield alias.name, None
        elif isinstance(node, ast.ImportFrom) and (node.module or "").startswith("tendon_mj"):
            for alias in node.names:
                yield node.module, alias.name


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_readme_and_docs_use_public_names_only(page):
    for code in re.findall(r"```(?:python|py)\n(.*?)```", page.read_text("utf-8"), re.S):
        for module, name in imported_names(code):
            assert module in {"tendon_mj", *APART}
            assert module in APART or name is None or name in tendon_mj.__all__
        for name in re.findall(r"\btendon_mj\.(\w+)\(", code):
            assert name in tendon_mj.__all__
