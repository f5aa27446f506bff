"""Makes `examples/your_rig.ipynb` of the page `docs/your_rig.md`.

`python -m experiments.make_notebook`. A Python block of the page becomes a cell, a block of
commands a cell that runs them, and the description in TOML one that writes it. What is between is
text.
"""

from __future__ import annotations

import json
import re
from pathlib import Path

ROOT = Path(__file__).parents[1]
PAGE, NOTEBOOK = ROOT / "docs" / "your_rig.md", ROOT / "examples" / "your_rig.ipynb"
_BLOCK = re.compile(r"```(python|sh|toml)\n(.*?)```\n", re.DOTALL)
_LINK = re.compile(r"\]\((?!https?:|#)([^)]+)\)")


def notebook_text(page: str) -> str:
    """The notebook as JSON text, of a page in Markdown."""
    cells, end = [], 0
    for block in _BLOCK.finditer(page):
        cells += [_text(page[end : block.start()]), _code(*block.groups())]
        end = block.end()
    cells.append(_text(page[end:]))
    kept = [cell for cell in cells if cell["source"]]
    for number, cell in enumerate(kept):
        cell["id"] = f"cell-{number}"
    python = {"display_name": "Python 3", "language": "python", "name": "python3"}
    whole = {
        "cells": kept,
        "metadata": {"kernelspec": python, "language_info": {"name": "python"}},
        "nbformat": 4,
        "nbformat_minor": 5,
    }
    return json.dumps(whole, indent=1, ensure_ascii=False, sort_keys=True) + "\n"


def _text(markdown: str) -> dict[str, object]:
    """A cell of text; links lead from the notebook's folder to where they led from the page's."""
    moved = _LINK.sub(lambda link: f"]({_from_examples(link[1])})", markdown.strip())
    return {"cell_type": "markdown", "metadata": {}, "source": moved.splitlines(keepends=True)}


def _from_examples(target: str) -> str:
    if target.startswith("../"):
        return target.removeprefix("../examples/") if "../examples/" in target else target
    return f"../docs/{target}"


def _code(language: str, block: str) -> dict[str, object]:
    code = block.strip()
    if language == "sh":
        run = "!{sys.executable} -m tendon_mj "
        code = "import sys\n\n" + code.replace("tendon-mj ", run)
    elif language == "toml":
        model = re.search(r'model = "(\w+)\.xml"', code)
        code = f"%%writefile {model[1] if model else 'rig'}.toml\n{code}"
    return {
        "cell_type": "code",
        "execution_count": None,
        "metadata": {},
        "outputs": [],
        "source": code.splitlines(keepends=True),
    }


def main() -> None:
    """Write the notebook."""
    NOTEBOOK.parent.mkdir(exist_ok=True)
    NOTEBOOK.write_text(notebook_text(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
    print(NOTEBOOK)


if __name__ == "__main__":
    main()
