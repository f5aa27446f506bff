"""Makes `examples/your_rig.ipynb` of the page `docs/your_rig.md`, and stores what it prints.

`python -m experiments.make_notebook`. A Python block of the page becomes a cell, a block of
commands a cell that runs them and shows their pictures, and the description in TOML one that writes
it. What is between is text. The notebook runs in an empty folder, for about a minute.
"""

from __future__ import annotations

import json
import re
import tempfile
from pathlib import Path
from typing import Any

import nbformat
from nbclient import NotebookClient

ROOT = Path(__file__).parents[1]
PAGE, NOTEBOOK = ROOT / "docs" / "your_rig.md", ROOT / "examples" / "your_rig.ipynb"
_BLOCK = re.compile(r"```(python|sh|toml)\n(.*?)```\n", re.DOTALL)
_COMMAND = re.compile(r"tendon-mj (check|diagnose) (\w+)\.csv(?:.* --out (\S+))?")
_SHOWN = {"check": ("{stem}",), "diagnose": ("before_after", "misfit", "proof", "gap")}
_CONTROL = re.compile(r"\x1b\[[0-9;?]*[A-Za-z]|\r")
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
        code = "import sys\n\n" + code.replace("tendon-mj ", run) + _pictures(code)
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


def _pictures(commands: str) -> str:
    """Code that shows the pictures of the last command that draws some; empty if none does."""
    ran = _COMMAND.findall(commands)
    if not ran:
        return ""
    command, stem, out = ran[-1]
    folder = out or f"out/{command}"
    names = _SHOWN[command][-2:] if out else _SHOWN[command]  # of a second rig fewer
    files = [f"{folder}/{name.format(stem=stem)}.png" for name in names]
    show = "from IPython.display import Image, display"
    return f"\n\n{show}\n\ndisplay(*map(Image, {files}))".replace("'", '"')


def _without_bars(outputs: list[Any]) -> list[Any]:
    """Outputs of a cell with its text in one piece, without progress bars and colours."""
    text = "".join(output.text for output in outputs if output.output_type == "stream")
    lines = _CONTROL.sub("", text).splitlines(keepends=True)
    kept = "".join(line for line in lines if "━" not in line).strip()
    others = [output for output in outputs if output.output_type != "stream"]
    return [nbformat.v4.new_output("stream", text=f"{kept}\n"), *others] if kept else others


def sources(notebook: str) -> list[Any]:
    """Cells of a notebook without what they printed."""
    kept = "id", "cell_type", "source"
    return [{key: cell[key] for key in kept} for cell in json.loads(notebook)["cells"]]


def main() -> None:
    """Write the notebook, once it has run."""
    notebook = nbformat.reads(notebook_text(PAGE.read_text(encoding="utf-8")), as_version=4)
    with tempfile.TemporaryDirectory() as folder:
        resources = {"metadata": {"path": folder}}
        NotebookClient(notebook, timeout=600, resources=resources).execute()
    for cell in notebook.cells:
        cell.metadata.pop("execution", None)  # times of this machine
        if cell.cell_type == "code":
            cell.outputs = _without_bars(cell.outputs)
    NOTEBOOK.write_text(nbformat.writes(notebook) + "\n", encoding="utf-8")
    print(NOTEBOOK)


if __name__ == "__main__":
    main()
