"""Budget of code lines of each package, which may only fall: ``python -m experiments.budget``.

Code lines are neither docstring nor comment nor blank. `budget.toml` holds the lines of each
package, and each rise with its reason. The check fails if a package has more lines, and if it has
fewer, so that lines that were saved are not spent again unnoticed.
"""

from __future__ import annotations

import argparse
import ast
import io
import sys
import tokenize
import tomllib
from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import tomli_w

ROOT = Path(__file__).resolve().parents[1]

_NO_CODE = {
    tokenize.COMMENT,
    tokenize.NL,
    tokenize.NEWLINE,
    tokenize.INDENT,
    tokenize.DEDENT,
    tokenize.ENDMARKER,
}


@dataclass(frozen=True)
class Rise:
    """Lines that a package was given, and the reason."""

    package: str
    lines: int
    reason: str


@dataclass(frozen=True)
class Budget:
    """Lines of each package, and the rises on top of them."""

    lines: dict[str, int]
    rises: tuple[Rise, ...] = ()

    @classmethod
    def read(cls, path: Path) -> Budget:
        """Read the table; an absent file is an empty one."""
        table = tomllib.loads(path.read_text(encoding="utf-8")) if path.exists() else {}
        return cls(table.get("lines", {}), tuple(Rise(**rise) for rise in table.get("rises", ())))

    def write(self, path: Path) -> None:
        """Write the table."""
        head = f"# {(__doc__ or '').splitlines()[0]}\n\n"
        table = {"lines": self.lines, "rises": [asdict(rise) for rise in self.rises]}
        path.write_text(head + tomli_w.dumps(table), encoding="utf-8")

    def excess(self, counted: dict[str, int]) -> dict[str, int]:
        """Lines of each package beyond its budget, negative if there are fewer."""
        packages = sorted({*counted, *self.lines, *(rise.package for rise in self.rises)})
        allowed = Counter(self.lines)
        for rise in self.rises:
            allowed[rise.package] += rise.lines
        excess = {package: counted.get(package, 0) - allowed[package] for package in packages}
        return {package: lines for package, lines in excess.items() if lines}

    def updated(self, counted: dict[str, int], reason: str) -> Budget:
        """Budget of the lines that were ``counted``; what rose is a rise with the ``reason``."""
        excess = self.excess(counted)
        lines = {
            package: self.lines.get(package, 0) + min(0, excess.get(package, 0))
            for package in sorted({*counted, *self.lines})
        }
        rises = [Rise(package, more, reason) for package, more in excess.items() if more > 0]
        return Budget(lines, (*self.rises, *rises))


def code_lines(source: str) -> int:
    """Count the lines that are neither docstring nor comment nor blank."""
    lines: set[int] = set()
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        if token.type not in _NO_CODE:
            lines.update(range(token.start[0], token.end[0] + 1))
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            lines.difference_update(range(node.lineno, (node.end_lineno or node.lineno) + 1))
    return len(lines)


def count_packages(root: Path) -> dict[str, int]:
    """Code lines of each package below ``root``; those of `lab` and `plugin` count alone."""
    total: Counter[str] = Counter()
    for path in sorted([*root.rglob("*.py"), *root.rglob("*.pyi")]):
        folders = path.relative_to(root).parts[:-1]
        depth = 2 if folders[:1] in [("lab",), ("plugin",)] else 1
        package = ".".join((root.name, *folders[:depth]))
        total[package] += code_lines(path.read_text(encoding="utf-8"))
    return dict(total)


def main(arguments: Sequence[str] | None = None, root: Path = ROOT) -> int:
    """Check the budget, or update it; returns 1 if a package has other lines than its budget."""
    parser = argparse.ArgumentParser(prog="python -m experiments.budget")
    parser.add_argument("--update", action="store_true", help="write the lines that fell")
    parser.add_argument("--reason", default="", help="why packages must grow; needs --update")
    options = parser.parse_args(arguments)
    path = root / "budget.toml"
    budget, counted = Budget.read(path), count_packages(root / "tendon_mj")
    excess = budget.excess(counted)
    if options.update and (options.reason or all(more < 0 for more in excess.values())):
        budget.updated(counted, options.reason).write(path)
        return 0
    for package, more in excess.items():
        change = f"{more} more: take lines away, or give a reason" if more > 0 else f"{-more} fewer"
        print(f"{package} has {counted.get(package, 0)} code lines, {change}", file=sys.stderr)
    if excess:
        print(f'{parser.prog} --update [--reason "…"] writes budget.toml', file=sys.stderr)
    return 1 if excess else 0


if __name__ == "__main__":
    sys.exit(main())
