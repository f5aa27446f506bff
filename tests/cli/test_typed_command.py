"""A command is stated as it can be typed."""

import shlex
from pathlib import Path

from tendon_mj.cli.typed_command import typed_command


def test_every_kind_of_option_is_told_as_it_was_given():
    options = {
        "--out": Path("a folder"),
        "--exclude": ("creep", "backlash"),
        "--settle": 0.0,
        "--model": None,
        "--hold-out": (),
        "--again": True,
        "--quick": False,
    }
    typed = typed_command("diagnose", [Path("one.csv"), "it's.csv"], options)
    assert shlex.split(typed) == [
        *("tendon-mj", "diagnose", "one.csv", "it's.csv", "--out", "a folder"),
        *("--exclude", "creep", "backlash", "--settle", "0.0", "--again"),
    ]
