"""Files of strangers: no code of theirs runs, nothing is written outside `--out`, nothing fetched.

Python's audit hooks see every file that is opened to be written, every connection, every program
that is run and every name that a pickle looks up. All commands run in one process.
"""

import json
import pickle
import subprocess
import sys
from pathlib import Path

import pytest

from tendon_mj.models import example_recording
from tests.lab.recordings.tables import log

WATCHED = """
import json, os, sys
from tendon_mj.cli import main
import tendon_mj.lab.diagnosis, tendon_mj.show.report  # what is read while they load is not watched

FILES = ("os.remove", "os.rename", "os.mkdir", "os.rmdir", "os.link", "os.symlink", "os.chmod")
ACTS = ("socket.connect", "socket.getaddrinfo", "os.system", "os.exec", "os.posix_spawn",
        "subprocess.Popen", "pickle.find_class", "urllib.Request")
seen = []

def watch(event, arguments):
    if event == "open":
        path, mode, flags = arguments
        if isinstance(path, (str, bytes)) and flags & (os.O_WRONLY | os.O_RDWR | os.O_CREAT):
            seen.append([event, os.path.abspath(os.fsdecode(path))])
    elif event in FILES and isinstance(arguments[0], (str, bytes)):  # not a file that is open
        seen.append([event, os.path.abspath(os.fsdecode(arguments[0]))])
    elif event in ACTS:
        seen.append([event, repr(arguments)])

sys.addaudithook(watch)
told = []
for arguments in json.loads(sys.stdin.read()):
    status = main(arguments)
    told.append([status, seen[:]])
    seen.clear()
open(sys.argv[1], "w").write(json.dumps(told))
"""
CODE = "__import__('pathlib').Path('pwned').touch()"
QUOTED = f'"); {CODE}#'  # ends the string that it is written into
FORMULA = "=cmd|'/c calc'!A0"
OUTSIDE = "../../pwned"
KINDS = ("nothing", "cell", "header", "comment", "unit", "source", "model", "sensor", "parameter")
MODEL = """{before}<mujoco model="{name}">
  <worldbody>
    <site name="{name}"/>
    <body pos="1 0 0">
      <joint name="{name}" type="slide" axis="1 0 0"/>
      <geom size="0.1"/>
      <site name="{name}_end"/>
    </body>
  </worldbody>
  <tendon>
    <spatial name="{name}" stiffness="100" springlength="0 0.9">
      <site site="{name}"/>
      <site site="{name}_end"/>
    </spatial>
  </tendon>
  <actuator><motor name="{name}" tendon="{name}"/></actuator>
  <sensor><tendonpos name="{name}" tendon="{name}"/></sensor>
  {within}
</mujoco>
"""
ENTITIES = "".join(f"<!ENTITY e{k} '{f'&e{k - 1};' * 10}'>" for k in range(1, 12))
MODELS = {  # name, before and within the model
    "code": (CODE, "", ""),
    "outside": (OUTSIDE, "", ""),
    "markup": ("&lt;script&gt;{{ 7 * 7 }}", "", ""),
    "entity": (
        "a",
        "<!DOCTYPE a [<!ENTITY x SYSTEM 'http://localhost:9/'>]>",
        "<custom>&x;</custom>",
    ),
    "entities": ("a", f"<!DOCTYPE a [<!ENTITY e0 'aa'>{ENTITIES}]>", "<custom>&e11;</custom>"),
    "include": ("a", "", "<include file='http://localhost:9/a.xml'/>"),
    "mesh": ("a", "", "<asset><mesh name='m' file='http://localhost:9/a.stl'/></asset>"),
    "library": ("a", "", f"<extension><plugin plugin='{OUTSIDE}.so'/></extension>"),
}
OUT = ("--out", "{out}")
RUNS = {  # name → arguments, and exit statuses
    **{
        f"{command} {kind}": (
            [command, f"{kind}.csv", *OUT],
            (0,) if kind in ("nothing", "source") else (0, 2),
        )
        for command in ("check", "replay")
        for kind in KINDS
    },
    "check Parquet": (["check", "pickle.parquet", *OUT], (2,)),
    "check MCAP": (["check", "log.mcap", *OUT], (2,)),
    "check bag": (["check", "type.mcap", *OUT], (2,)),
    "check bag of ROS 2": (["check", "field.mcap", *OUT], (2,)),
    "diagnose bounds": (["diagnose", "source.csv", "--next", "bounds.toml", *OUT], (2,)),
    "simulate motion": (["simulate", "finger", "--motion", "cell.csv", *OUT], (2,)),
    "render motion": (["render", "bench", "--motion", "cell.csv", *OUT], (2,)),
    "fleet": (["fleet", "rigs", "--processes", "1", *OUT], (0, 2)),
    **{
        f"{command} {kind}": ([command, f"{kind}.xml", *words], statuses)
        for kind in MODELS
        for command, words, statuses in (
            ("attach", ("--tendon", "*", "--friction", "0.1", "--out", "{out}/new.xml"), (0, 2)),
            ("init", ("--out", "{out}/new.toml"), (0, 2)),
        )
    },
}


class Code:
    """What runs when a pickle of it is read."""

    def __reduce__(self):
        return eval, (CODE,)


def write_models(folder):
    """Models with code in their names, and with what a reader might fetch or expand."""
    for kind, (name, before, within) in MODELS.items():
        (folder / f"{kind}.xml").write_text(MODEL.format(name=name, before=before, within=within))


def write_tables(folder):
    """A Parquet file whose column is a pickle by its type, and logs whose messages or types are."""
    pa = pytest.importorskip("pyarrow")
    described = example_recording().with_suffix(".toml").read_text()
    kind = {
        "ARROW:extension:name": "arrow.py_extension_type",
        "ARROW:extension:metadata": pickle.dumps(Code()),
    }
    time, field = pa.array([0.0, 1.0]), pa.field("input_tension_N", pa.float64(), metadata=kind)
    schema = pa.schema([pa.field("time_s", pa.float64()), field], {"pandas": CODE})
    pq = pytest.importorskip("pyarrow.parquet")
    pq.write_table(pa.table([time, time], schema=schema), folder / "pickle.parquet")
    (folder / "pickle.toml").write_text(described)
    log(folder / "log.mcap", ("/cell", 0.0, {"f": CODE}), ("/cell", 1.0, {"f": 1.0}))
    topic = '[columns]\ninput_tension_N = { topic = "/cell", field = "f" }\n'
    (folder / "log.toml").write_text(described + topic)
    number = b"\0\1\0\0" + bytes(8)
    types = {"type": (f"a/msg/A{QUOTED}", "float64 f"), "field": ("a/msg/A", f"float64 f{QUOTED}")}
    for name, (kind, text) in types.items():
        schema = (kind, "ros2msg", text)
        messages = (("/cell", 0.0, number), ("/cell", 1.0, number))
        log(folder / f"{name}.mcap", *messages, encoding="cdr", schema=schema)
        (folder / f"{name}.toml").write_text(described + topic)


def write(kind, folder):
    """A recording with code in it."""
    table = example_recording().read_text().splitlines()[:200]
    described = example_recording().with_suffix(".toml").read_text()
    if kind == "cell":
        table[5] = f"{CODE}," + table[5].split(",", 1)[1]
    elif kind == "header":
        table = [table[0] + f",{FORMULA}", *(line + ",1" for line in table[1:])]
    elif kind == "comment":
        table.insert(0, f"# {CODE}")
    elif kind == "unit":
        table[0] = table[0].replace("_N", f"_{CODE}")
    elif kind == "source":
        described = described.replace('source = "', f'source = "{{{{ {CODE} }}}} <script>')
    elif kind == "model":
        described = described.replace('"bench"', f'"{CODE}"')
    elif kind == "sensor":
        described = described.replace('"input_tension"', f'"{CODE}"')
    elif kind == "parameter":
        described += f'\n[known]\n"{CODE}" = 1.0\n'
    (folder / f"{kind}.csv").write_text("\n".join(table) + "\n")
    (folder / f"{kind}.toml").write_text(described)


@pytest.fixture(scope="module")
def told(tmp_path_factory):
    """Folder of each command, and its exit status and what it did that was watched."""
    folder = tmp_path_factory.mktemp("untrusted")
    for kind in KINDS:
        write(kind, folder)
    write_tables(folder)
    write_models(folder)
    (folder / "bounds.toml").write_text(f'duration = "{CODE}"\n[drive]\n"{CODE}" = 1\n')
    (folder / "out").mkdir()
    rig = folder / "rigs" / "<script>"
    rig.mkdir(parents=True)
    (rig / "2026-01-01.csv").write_bytes((folder / "cell.csv").read_bytes())
    (rig / "2026-01-01.toml").write_bytes((folder / "source.toml").read_bytes())
    before = set(folder.rglob("*"))
    outs = {name: folder / "out" / name for name in RUNS}
    jobs = [
        [word.format(out=outs[name]) for word in arguments] for name, (arguments, _) in RUNS.items()
    ]
    report = tmp_path_factory.mktemp("report") / "report.json"
    done = subprocess.run(
        [sys.executable, "-c", WATCHED, report],
        input=json.dumps(jobs),
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
    )
    assert report.exists(), done.stderr
    written = set(folder.rglob("*")) - before
    assert all(path.is_relative_to(folder / "out") for path in written)  # MuJoCo's own files, too
    assert not list(folder.parent.rglob("pwned*"))
    return outs, dict(zip(RUNS, json.loads(report.read_text()), strict=True))


@pytest.mark.parametrize("name", RUNS)
def test_a_stranger_s_file_does_nothing_but_what_the_command_writes(name, told):
    outs, runs = told
    status, seen = runs[name]
    assert status in RUNS[name][1]
    caches = (Path.home() / ".cache", Path(sys.prefix), Path.home() / ".config")
    for event, what in seen:
        if event == "pickle.find_class" and "concurrent.futures" in what:
            continue  # results of the command's own processes
        path = Path(what)
        assert path.is_absolute(), (event, what)  # all else than a file is a program or connection
        assert any(path.is_relative_to(one) for one in (outs[name], *caches)), (event, what)
