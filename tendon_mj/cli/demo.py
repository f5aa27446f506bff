"""`tendon-mj demo`: comparison, clip, replay and diagnosis in one run."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Final

from tendon_mj.cli.bench import compare
from tendon_mj.cli.diagnose import diagnose
from tendon_mj.cli.motion import render
from tendon_mj.cli.output import Output, console
from tendon_mj.cli.recordings import replay
from tendon_mj.errors import EngineError
from tendon_mj.models import example_recording, example_rig

CLIP: Final[Any] = {"duration": 4.0, "size": "720x400", "fps": 10.0}  # a minute is for everything


def demo(out: Path = Path("out/demo")) -> dict[str, object]:
    """Compare with theory, render the pressing finger, replay a recording, diagnose a rig.

    Args:
        out: Folder for all files.

    Example:
        tendon-mj demo --out out/demo
    """
    output = Output(out)
    result: dict[str, object] = {}
    console.rule("compare")
    result["compare"] = compare(out / "compare")
    console.rule("render")
    try:
        result["render"] = render("finger", out / "render", motion="press", **CLIP)
    except EngineError as error:  # a machine without GL still shows the rest
        console.print(f"no clip: {error}")
        result["render"] = {"clip": None, "reason": str(error)}
    console.rule("replay")
    console.print("A recording made by the package, not measured.")
    result["replay"] = replay(example_recording(), out / "replay")
    console.rule("diagnose")
    console.print("The rig of docs/your_rig.md: simulated elsewhere, with a hidden cause.")
    rig = example_rig()
    result["diagnose"] = diagnosis = diagnose(
        (rig / "triangles.csv",),
        out / "diagnose",
        hold_out=((rig / "sines.csv",),),
        description=rig / "rig.toml",
        sysid=False,
    )
    written = sorted(p for p in out.rglob("*") if p.is_file())
    output.result(result)
    console.rule("all files")
    output.written = [*written, *output.written]
    output.close(
        f"The diagnosis is {diagnosis['verdict']}. {diagnosis['sentence']} "
        f"Its report: {out / 'diagnose' / 'report.html'}."
    )
    return result
