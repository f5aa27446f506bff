"""TOML of users: keys of very many parts and very long integers are refused, texts are not."""

from __future__ import annotations

import random

import pytest
import tomli_w

from tendon_mj.errors import RecordingError
from tendon_mj.lab.recordings import read_toml
from tendon_mj.lab.recordings.description_toml import parse_description
from tendon_mj.lab.recordings.toml_text import MOST_DIGITS, MOST_PARTS

DEEP = ".".join("a" * 20_000)
LAWFUL = ".".join("a" * MOST_PARTS)
DOTS = "a." * 200


@pytest.mark.parametrize(
    ("text", "line"),
    [
        (f"{DEEP} = 1", 1),
        (f"[{DEEP}]", 1),
        (f"x = 1\n[[{DEEP}]]", 2),
        (f"{LAWFUL}.a = 1", 1),
        (" . ".join(["a", '"b.c"', "'d'"] * 40) + " = 1", 1),
        (f"x = [{{ {DEEP} = 1 }}]", 1),
        (f'x = """\n\n\\""""\n# "\n{DEEP} = 1', 5),
        (f'x = {{ y = """"z"""", {DEEP} = 1 }}', 1),
        (f"x = {{ y = ''''z''''', {DEEP} = 1 }}", 1),
        (f"x = 'a\\'\n{DEEP} = 1", 2),
    ],
)
def test_a_key_of_very_many_parts_is_refused_with_its_line(text: str, line: int) -> None:
    with pytest.raises(RecordingError, match=f"^rig.toml, line {line}: a key has more than 100"):
        read_toml(text, "rig.toml")


def test_a_description_is_read_so() -> None:
    with pytest.raises(RecordingError, match=r"^rig.toml, line 3: a key has more than 100"):
        parse_description(f'model = "bench"\nsource = "made"\n{DEEP} = 1', "rig.toml")


@pytest.mark.parametrize(
    ("text", "line"),
    [
        (f"x = 0x{'f' * 4000}", 1),
        (f"x = 1\n[known]\n'a.b' = -{'9' * 4000}", 3),
        (f"x = 0b{'10' * 20_000}  # bits", 1),
        (f"x = 0o{'7_7' * 2000}", 1),
        (f"x = {{ low = 1, high = +{'9' * 5000}}}", 1),
        (f"x = [1,\n 2, 0xF{'0_0' * 500}]", 2),
    ],
)
def test_an_integer_of_very_many_digits_is_refused_with_its_line(text: str, line: int) -> None:
    with pytest.raises(RecordingError, match=f"^rig.toml, line {line}: an integer has 1000 digits"):
        read_toml(text, "rig.toml")


@pytest.mark.parametrize("entry", ["model = {}", 'model = "m"\nsource = "s"\n[known]\n"a.b" = {}'])
def test_a_description_with_one_is_refused_so(entry: str) -> None:
    with pytest.raises(RecordingError, match=r"^rig.toml, line \d: an integer has 1000 digits"):
        parse_description(entry.format("0x" + "f" * 4000), "rig.toml")


@pytest.mark.parametrize(
    "text",
    [
        f"x = 0x{'f' * (MOST_DIGITS - 1)}",
        f"x = 1{'0' * 4000}.5",
        f"x = {'1' * 4000}e5",
        f"x = 0.{'1' * 4000}",
        f"x = 1e-{'0' * 4000}1",
        f"x = '0x{'f' * 4000}'  # {'1' * 4000}",
        f"{'1' * 4000} = 1",
        f"a-{'1' * 4000}-b = 1",
    ],
    ids=range(8),
)
def test_digits_elsewhere_are_read(text: str) -> None:
    assert read_toml(text, "rig.toml")


@pytest.mark.parametrize(
    "text",
    [
        f"{LAWFUL} = 1",
        f"[{LAWFUL}]",
        f'x = "{DOTS}"',
        f"x = '{DOTS}'",
        f'x = "\'\\"{DOTS}"',
        f"x = 'C:\\{DOTS}\\'",
        f'x = """\n"\n""{DOTS}\n{DOTS}\\""""',
        f"x = '''\n'\n''{DOTS}\n{DOTS}''''",
        f"# it's {DOTS}\nx = 1 # \"{DOTS}",
        f'"{DOTS}" = 1',
        f'["{DOTS}"]',
        f"x = [{'0.5, ' * 200}]",
    ],
)
def test_dots_elsewhere_are_read(text: str) -> None:
    assert read_toml(text, "rig.toml")


def test_what_any_text_is_written_as_is_read_back() -> None:
    draw = random.Random(0)
    for trial in range(300):
        keys = ["".join(draw.choices(".'\"\\#\n a", k=draw.randrange(400))) for _ in range(3)]
        document = {key: "".join(draw.choices(".'\"\\#\n a", k=400)) for key in keys}
        text = tomli_w.dumps(document, multiline_strings=bool(trial % 2))
        assert read_toml(text, "rig.toml") == document
