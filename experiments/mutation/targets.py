"""What is mutated, and the tests that have to notice."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Final

_PYTEST: Final = "python -m pytest -x -q -p no:cacheprovider -p experiments.mutation.first_failure"
# Before the tests, in which every warning is an error: those of what this process cannot keep.
_COMPILE: Final = "python -m tendon_mj.compilation"


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


def _modules(folder: str, *names: str) -> tuple[Path, ...]:
    """Files of a folder of the package."""
    return tuple(Path("tendon_mj", folder, f"{name}.py") for name in names)


TARGETS: Final = {
    "sheath": Target(
        modules=_modules(
            "sheath",
            "law",
            "segment_law",
            "tension_solver",
            "tension_by_slip_pattern",
            "tension_by_sweep",
            "tension_with_drag",
        ),
        tests=f"{_PYTEST} -p experiments.mutation.without_engine tests/sheath",
        timeout=600.0,
    ),
    "engine": Target(
        modules=_modules(
            "plugin/sheath_plugin",
            "drive",
            "evaluate",
            "forces",
            "friction",
            "input_force",
            "state",
            "strain",
        ),
        tests=f"{_COMPILE} && {_PYTEST} tests/plugin tests/guarantees/test_laws.py",
        timeout=1200.0,
    ),
    "diagnosis": Target(
        modules=(
            *_modules("diagnosis", "proof", "verdict"),
            *_modules(
                "diagnosis/model_selection",
                "backtracking",
                "comparison",
                "confidence",
                "context",
                "cross_validation",
                "forward_selection",
                "screening",
                "select",
                "swap",
                "thresholds",
            ),
        ),
        tests=f"{_PYTEST} tests/lab/diagnosis",
        timeout=600.0,
    ),
}
