"""`tendon-mj demo`: comparison, clip and replay in one run."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Final

from tendon_mj.builders.load import example_recording
from tendon_mj.cli.compare import compare
from tendon_mj.cli.output import Output, console
from tendon_mj.cli.render import render
from tendon_mj.cli.replay import replay
from tendon_mj.errors import EngineError

CLIP: Final[Any] = {"duration": 4.0, "size": "720x400", "fps": 10.0}  # a minute is for everything


def demo(out: Path = Path("out/demo")) -> dict[str, object]:
    """Compare with theory, render the pressing finger, replay the example recording.

    Args:
        out: folder for everything.
    """
    output = Output(out)
    result: dict[str, object] = {}
    console.rule("compare")
    result["compare"] = compare(out / "compare")
    console.rule("render")
    try:
        result["render"] = render("finger", out / "render", motion="press", **CLIP)
    except EngineError as error:  # a machine without GL still shows the rest
        console.print(f"no clip: {error}", soft_wrap=True)
        result["render"] = {"clip": None, "reason": str(error)}
    console.rule("replay (a recording made by the package, not measured)")
    result["replay"] = replay(example_recording(), out / "replay")
    output.result(result)
    console.rule("all files")
    output.written = sorted(path for path in out.rglob("*") if path.is_file())
    output.close()
    return result
