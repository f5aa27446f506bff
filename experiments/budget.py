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
from pathlib import Path

import tomli_w

ROOT = Path(__file__).resolve().parents[1]

_LAYOUT = {tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT, tokenize.ENDMARKER}
_NO_CODE = {*_LAYOUT, tokenize.COMMENT}


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


def count_packages(root: Path) -> Counter[str]:
    """Code lines of each package below ``root``; those of `lab` and `plugin` count alone."""
    total: Counter[str] = Counter()
    for path in [*root.rglob("*.py"), *root.rglob("*.pyi")]:
        folders = path.relative_to(root).parts[:-1]
        depth = 2 if folders[:1] in [("lab",), ("plugin",)] else 1
        package = ".".join((root.name, *folders[:depth]))
        total[package] += code_lines(path.read_text(encoding="utf-8"))
    return total


def main(arguments: Sequence[str] | None = None, root: Path = ROOT) -> int:
    """Check the budget, or update it; returns 1 if a package has other lines than its budget."""
    parser = argparse.ArgumentParser(prog="python -m experiments.budget")
    parser.add_argument("--update", action="store_true", help="write the lines that fell")
    parser.add_argument("--reason", default="", help="why packages must grow; needs --update")
    options = parser.parse_args(arguments)
    path = root / "budget.toml"
    table = tomllib.loads(path.read_text(encoding="utf-8")) if path.exists() else {}
    lines, rises = Counter(table.get("lines", {})), list(table.get("rises", []))
    excess = count_packages(root / "tendon_mj")
    excess.subtract(lines)
    for rise in rises:
        excess[rise["package"]] -= rise["lines"]
    excess = Counter({package: more for package, more in sorted(excess.items()) if more})
    if options.update and (options.reason or max(excess.values(), default=0) <= 0):
        for package, more in excess.items():
            if more > 0:
                rises.append({"package": package, "lines": more, "reason": options.reason})
            lines[package] += min(more, 0)
        head = f"# {(__doc__ or '').splitlines()[0]}\n\n"
        text = tomli_w.dumps({"lines": dict(sorted(lines.items())), "rises": rises})
        path.write_text(head + text, encoding="utf-8")
        return 0
    for package, more in excess.items():
        change = f"{more} more: take lines away, or give a reason" if more > 0 else f"{-more} fewer"
        print(f"{package}: {change}", file=sys.stderr)
    if excess:
        print(f'{parser.prog} --update [--reason "…"] writes budget.toml', file=sys.stderr)
    return 1 if excess else 0


if __name__ == "__main__":
    sys.exit(main())
