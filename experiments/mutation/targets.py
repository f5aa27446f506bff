"""Targets of mutation, and the tests that have to notice."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Final

_ROOT: Final = Path(__file__).parents[2]
_PYTEST: Final = "python -m pytest -x -q -p no:cacheprovider -p experiments.mutation.first_failure"
# Compiles before the tests, in which every warning is an error, also one of an unwritable cache.
_COMPILE: Final = "python -m tendon_mj.native"


@dataclass(frozen=True)
class Target:
    """A part of the package.

    Attributes:
        modules: files, from the root of the project.
        tests: shell command that runs the tests, those that fail soonest first.
        timeout: after which a mutant counts as killed [s].
    """

    modules: tuple[Path, ...]
    tests: str
    timeout: float


def _modules(folder: str) -> tuple[Path, ...]:
    """Modules of a folder of the package, without its face."""
    files = sorted((_ROOT / "tendon_mj" / folder).rglob("*.py"))
    return tuple(file.relative_to(_ROOT) for file in files if file.name != "__init__.py")


TARGETS: Final = {
    "sheath": Target(
        modules=_modules("sheath"),
        tests=f"{_PYTEST} -p experiments.mutation.without_engine tests/sheath",
        timeout=600.0,
    ),
    "engine": Target(
        modules=_modules("plugin"),
        tests=f"{_COMPILE} && {_PYTEST} tests/plugin tests/guarantees/test_laws.py",
        timeout=1200.0,
    ),
    "diagnosis": Target(
        modules=_modules("lab/diagnosis"), tests=f"{_PYTEST} tests/lab/diagnosis", timeout=600.0
    ),
}
