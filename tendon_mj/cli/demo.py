"""`tendon-mj demo`: comparison, clip and replay in one run."""

from __future__ import annotations

from pathlib import Path

from tendon_mj.builders.load import example_recording
from tendon_mj.cli.compare import compare
from tendon_mj.cli.output import Output, console
from tendon_mj.cli.render import render
from tendon_mj.cli.replay import replay
from tendon_mj.errors import EngineError


def demo(out: Path = Path("out/demo")) -> dict[str, object]:
    """Compare with theory, render a clip, replay the example recording.

    Args:
        out: folder for everything.

    Example:
        tendon-mj demo --out out/demo
    """
    output = Output(out)
    result: dict[str, object] = {}
    console.rule("compare")
    result["compare"] = compare(out / "compare")
    console.rule("render")
    try:
        result["render"] = render("bench", out / "render")
    except EngineError as error:  # a machine without GL still shows the rest
        console.print(f"no clip: {error}", soft_wrap=True)
        result["render"] = {"clip": None, "reason": str(error)}
    console.rule("replay (a recording made by the package, not measured)")
    result["replay"] = replay(example_recording(), out / "replay")
    output.result(result)
    console.rule("all files")
    output.written = sorted(path for path in out.rglob("*") if path.is_file())
    output.close(f"All of it is in {out}: begin with the pictures of compare.")
    return result
