"""Command lines with missing, absurd and misplaced words: carried out, refused or interrupted.

Each command begins as one that its user would type, on files of a folder of its own. What is not
refused is interrupted after a moment, as by Ctrl-C.
"""

from __future__ import annotations

import contextlib
import io
import os
import random
import shutil
import signal
import tempfile
import traceback
import warnings
from collections.abc import Iterator, Sequence
from pathlib import Path

import mujoco

from experiments.soak.batches import report_batch
from experiments.soak.killed_runs import whole
from experiments.soak.model_fuzz import DRIVEN
from tendon_mj.cli import COMMANDS, load_command, main
from tendon_mj.models import example_recording, load_spec

_ENDINGS = {0: "carried out", 2: "refused", 130: "interrupted"}
_LONGEST = 0.4  # [s] until the last moment of an interruption
_MOST_LINES = 150  # of a refusal: if no command is named, it lists them all
_TABLE = "loop.csv"
# by command; none of them opens a window, and one process does the work of those that have many
_TYPED = (
    "attach arm.xml --tendon t --friction 0.2 --out out/new.xml --arc-guides 4 --inner-guides 1",
    "attach bench.xml --tendon tendon --friction 0.2 --out out/new.xml --axial-stiffness 1e4",
    "bench arm.xml --out out --rounds 1",
    "compare --out out",
    "init arm.xml --out out/arm.toml",
    "check loop.csv --out out --description loop.toml --model bench --settle 0.1",
    "replay loop.csv --out out --change sheath.friction=0.1 --change sheath.pretension=20",
    "diagnose loop.csv --out out --hold-out more.csv --exclude creep --no-sysid --model bench",
    "render arm.xml --out out --duration 0.1 --size 64x48 --fps 10 --no-twin",
    "render bench --out out --motion press --camera side --duration 0.1",
    "simulate finger --motion tap --out out --friction 0.1 --no-clip --no-clamp",
    "sweep arm.xml --parameter s.friction=0.1:0.3:2 --out out --duration 0.02 --processes 1",
    "sweep bench --parameter sheath.friction=0:1 --draws 2 --seed 1 --outputs *.max --processes 1 "
    "--out out --recording loop.csv --settle 0",
    "fleet rigs --out out --processes 1",
)
_WORDS = (
    *("", " ", "-", "--", "-1", "0", "1e308", "-1e308", "1e-308", "nan", "inf", "1e400", "1_0"),
    *(
        "0x10",
        "9" * 400,
        "99999999999",
        "1e12",
        "--out",
        "--out=",
        "--model",
        "--help",
        "-h",
        "--x",
    ),
    *("a=b", "=", "=1", "sheath.friction=", "sheath.friction=nan", "*.*=1", "[", "[bold]", "{0}"),
    *("%s%n", "é", "\udcff", "\u200b", "\n", "\x1b[31m", "../x", "out", "out/../out", "/dev/null"),
    *("/proc/none", "missing.csv", "missing.xml", "loop.csv", "loop.toml", "arm.xml", "empty.csv"),
    *(
        "None",
        "True",
        "description",
        "1x1",
        "0x0",
        "99999999x1",
        "tcp://127.0.0.1:1",
        "t",
        "tendon",
    ),
)


def trials(seed: int, count: int) -> Iterator[tuple[str, str]]:
    """Type commands, and check their endings and their files."""
    warnings.simplefilter("ignore")
    draw = random.Random(seed)
    signal.signal(signal.SIGALRM, lambda *_: signal.raise_signal(signal.SIGINT))
    with tempfile.TemporaryDirectory() as whole_files, contextlib.chdir("/"):
        _fill(Path(whole_files))
        with contextlib.redirect_stdout(io.StringIO()):
            for command in COMMANDS:  # an import that was cut off fails later
                load_command(command)
                with contextlib.suppress(SystemExit):
                    main([command, "--help"])
        for _ in range(count):
            typed = _mistyped(draw.choice(_TYPED).split(" "), draw)
            with tempfile.TemporaryDirectory() as parent:
                folder = Path(parent, "a", "b")  # so that ../x is ours too
                shutil.copytree(whole_files, folder)
                before = _written(Path(parent))
                with contextlib.chdir(folder):
                    outcome, said = _run(typed, draw.uniform(0.0, _LONGEST))
                changed = [
                    path
                    for path, when in _written(Path(parent)).items()
                    if before.get(path) != when
                ]
                wrong = said or _left_wrong(folder, changed, typed)
            yield outcome, f"{wrong}: {typed}" if wrong else ""
    exec("")  # where the last code given as text was interrupted, CPython would end by SIGINT


def _fill(folder: Path) -> None:
    """A model, a recording, and a folder of rigs."""
    (folder / "arm.xml").write_text(DRIVEN)
    (folder / "bench.xml").write_text(load_spec("bench").to_xml())
    (folder / "empty.csv").touch()
    source = example_recording()
    rows = source.read_text().splitlines()[:80]
    for name in (_TABLE, "more.csv", "rigs/one/2026-03-01.csv", "rigs/two/2026-03-01.csv"):
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("\n".join(rows) + "\n")
        shutil.copy(source.with_suffix(".toml"), path.with_suffix(".toml"))


def _mistyped(words: list[str], draw: random.Random) -> list[str]:
    """A command with a few of its words replaced, removed, added, doubled or misplaced."""
    for _ in range(draw.choice([0, 1, 1, 1, 2, 3])):
        k = draw.randrange(len(words))
        kind = draw.randrange(6)
        if kind <= 1:
            words[k] = draw.choice(_WORDS)
        elif kind == 2:
            words.insert(k + 1, draw.choice(_WORDS))
        elif kind == 3:
            words.insert(draw.randrange(len(words)), words[k])
        elif kind == 4:
            other = draw.randrange(len(words))
            words[k], words[other] = words[other], words[k]
        elif len(words) > 1:
            del words[k]
    return words


def _run(typed: Sequence[str], moment: float) -> tuple[str, str]:
    """Ending of a command that is interrupted after a moment [s], and its faults."""
    out, err = io.StringIO(), io.StringIO()
    signal.signal(signal.SIGINT, signal.default_int_handler)  # as a process begins
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            status = _interrupted(typed, moment)
        except SystemExit as end:
            status = end.code if isinstance(end.code, int) else 2
        except KeyboardInterrupt:  # which came when all was done
            status = 130
        except Exception:
            return "broken", traceback.format_exc()
    said = err.getvalue() + out.getvalue()
    if status not in _ENDINGS:
        return "broken", f"status {status}"
    lost = "Exception ignored" in said and "KeyboardInterrupt" in said  # in a finaliser, by Python
    if "Traceback" in said and not lost:
        return _ENDINGS[status], said
    lines = len(said.splitlines())
    if status == 2 and not 1 <= lines <= _MOST_LINES:
        return _ENDINGS[status], f"refused in {lines} lines"
    return _ENDINGS[status], ""


def _interrupted(typed: Sequence[str], moment: float) -> int:
    """Exit status of a command line that is interrupted after a moment [s]."""
    signal.setitimer(signal.ITIMER_REAL, max(moment, 1e-3))
    try:
        return main(typed)
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)


def _written(folder: Path) -> dict[Path, int]:
    """Files below a folder, and when each was written."""
    return {path: path.lstat().st_mtime_ns for path in folder.rglob("*") if not path.is_dir()}


def _left_wrong(folder: Path, changed: Sequence[Path], typed: Sequence[str]) -> str:
    """A file that is half-written, or that lies where the command was not told to write."""
    default = {"arm.toml"} if typed[:1] == ["init"] and "None" in typed else set()  # of --out None
    named = {"out", *default, *typed, *(word.partition("=")[2] for word in typed)}
    told = {Path(os.path.normpath(folder / name)) for name in named if name}
    for path in changed:
        if not whole(path):
            return f"{path.name} is half-written"
        if not told & {path, *path.parents} or path.name == _TABLE:
            return f"{path.relative_to(folder.parent.parent)} was written"
    return ""


if __name__ == "__main__":
    mujoco.set_mju_user_warning(lambda _: None)
    report_batch(trials)
