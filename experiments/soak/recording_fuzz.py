"""Recordings and descriptions with broken or absurd bytes: refused by file and place, or read."""

from __future__ import annotations

import io
import json
import random
import tempfile
import warnings
from collections.abc import Iterator, Mapping
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq
from mcap.writer import Writer

from experiments.soak.batches import report_batch
from tendon_mj.errors import TendonError
from tendon_mj.lab.recordings import read_recording, read_table
from tendon_mj.models import example_recording
from tendon_mj.typing import FloatArray

_ROWS = 12  # of the recording that is broken
_CELLS = (
    *("", " ", "nan", "inf", "-inf", "1e308", "1e400", "-1e308", "1e-320", "0x1p3", "1_0", "1;2"),
    *("True", "None", "é", "\x00", "\ufeff", '"', '"1"', "=1+1", "__import__('os')", "9" * 500),
    *("2026-03-02T10:15:02", "10:15", "1766147454233218075", "9" * 19, "9999-12-31", '"', "#", ";"),
    *("time_s", "1\r", "\r\n", "\u2028", "\t", "1 N", "+", "--1", "1e", "٣"),
)
_LINES = (
    *("model = 3", 'model = ""', 'model = "/etc/passwd"', "model = [", "[known]", "[[known]]"),
    *(
        "[uncertain]",
        "[measured]",
        "[session]",
        "[drive]",
        "noise = nan",
        "noise = -1",
        "x = 1e999",
    ),
    *(
        "[columns]",
        'time_s = "time_s"',
        'time_ns = { column = "time_s" }',
        'header = ["a", "time_s"]',
    ),
    *(
        'input_tension_N = "output_tension_N"',
        "factor = 1e-30",
        'x_N = { column = "", period = 1 }',
    ),
    *('a = "\\u0000"', "settle = 1e300", "settle = -1", "hold = 3", "= 1", "'x' = 1979-05-27"),
    *('"*.friction" = 0.1', '"*.friction" = { low = 2, high = 1 }', '"" = 1', "a.b.c = {}"),
    *("settle = 0x10", '"sheath.friction" = 0b1', "x = 0o7", "settle = 0x"),
)


def broken(data: bytes, draw: random.Random, parts: tuple[str, ...], at: bytes) -> bytes:
    """Bytes with a few changes: cells or lines replaced, removed or doubled; bytes at random."""
    for _ in range(draw.randint(1, 3)):
        kind = draw.randrange(6)
        pieces = data.split(at)
        k = draw.randrange(len(pieces))
        if kind == 0:
            pieces[k] = draw.choice(parts).encode()
        elif kind == 1:
            pieces.insert(k, draw.choice(parts).encode())
        elif kind == 2:
            del pieces[k]
        elif kind == 3:
            pieces.insert(k, pieces[k])
        data = at.join(pieces)
        if kind == 4 and data:
            cut = draw.randrange(len(data))
            data = data[:cut] + bytes(draw.randrange(256) for _ in range(3)) + data[cut + 1 :]
        elif kind == 5:
            data = data[: draw.randrange(len(data) + 1)]
    return data


def _binary(table: Mapping[str, FloatArray], folder: Path) -> dict[str, bytes]:
    """Suffix → bytes of the first rows of a table as Parquet and as an MCAP."""
    parquet, mcap = folder / "whole.parquet", io.BytesIO()
    pq.write_table(pa.table({name: values[:_ROWS] for name, values in table.items()}), parquet)
    writer = Writer(mcap)
    writer.start()
    channel = writer.register_channel("/rig", "json", schema_id=0)
    for row in zip(*(values[:_ROWS].tolist() for values in table.values()), strict=True):
        time = round(row[0] * 1e9)
        data = json.dumps(dict(zip(table, row, strict=True))).encode()
        writer.add_message(channel, log_time=time, publish_time=time, data=data)
    writer.finish()  # type: ignore[no-untyped-call]
    return {".parquet": parquet.read_bytes(), ".mcap": mcap.getvalue()}


def trials(seed: int, count: int) -> Iterator[tuple[str, str]]:
    """Read recordings of which the table, the description or both are broken."""
    warnings.simplefilter("ignore")
    draw = random.Random(seed)
    source = example_recording()
    rows = source.read_bytes().split(b"\n")[: _ROWS + 1]
    table, described = b"\n".join(rows), source.with_suffix(".toml").read_bytes()
    with tempfile.TemporaryDirectory() as folder:
        tables = {".csv": table, **_binary(read_table(source), Path(folder))}
        of_log = b"\n[columns]\n" + b"".join(
            b'%s = { topic = "/rig", field = "%s" }\n' % (name, name)
            for name in rows[0].split(b",")[1:]
        )
        for _ in range(count):
            which, suffix = draw.randrange(3), draw.choice(list(tables))
            path = Path(folder) / f"recording{suffix}"
            broken_table = tables[suffix]
            if which != 1:
                at = draw.choice([b",", b"\n"])
                broken_table = broken(broken_table, draw, _CELLS, at)
            path.write_bytes(broken_table)
            toml = described + (of_log if suffix == ".mcap" else b"")
            toml = broken(toml, draw, _LINES, b"\n") if which != 0 else toml
            path.with_suffix(".toml").write_bytes(toml)
            try:
                read_recording(path)
                yield "read", ""
            except TendonError as error:
                named = path.name in str(error) or "recording.toml" in str(error)
                yield "refused", "" if named else f"the refusal names no file: {error}"
            except Exception as error:
                kept = Path(folder).parent / f"broken_{seed}_{draw.randrange(10**6)}{suffix}"
                kept.write_bytes(broken_table)
                kept.with_suffix(".toml").write_bytes(toml)
                yield "broken", f"{type(error).__name__}: {error} ({kept})"


if __name__ == "__main__":
    report_batch(trials)
