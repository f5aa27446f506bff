"""The budget of code lines notices lines more and fewer, and takes a rise only with a reason."""

import pytest

from experiments.budget import code_lines, main

MODULE = '''"""Two
lines."""

import os  # of the system


def name():
    """Name."""
    # of this
    return (
        os.name
    )
'''


@pytest.fixture
def root(tmp_path):
    for package in ("", "lab/replay", "plugin/abi"):
        (tmp_path / "tendon_mj" / package).mkdir(parents=True, exist_ok=True)
        (tmp_path / "tendon_mj" / package / "module.py").write_text(MODULE)
    assert main(["--update", "--reason", "first"], tmp_path) == 0
    return tmp_path


def test_docstrings_comments_and_blanks_are_no_code():
    assert code_lines(MODULE) == 5
    assert code_lines("x = '''a\n\nb'''\n") == 3


@pytest.mark.parametrize("package", ["", "lab/replay", "plugin/abi"])
def test_a_planted_line_fails_the_check(root, package, capsys):
    assert main([], root) == 0
    with (root / "tendon_mj" / package / "module.py").open("a") as module:
        module.write("# a comment\nplanted = 1\n")
    for arguments in ([], ["--update"]):  # a rise needs a reason
        assert main(arguments, root) == 1
        place = ".".join(["tendon_mj", *package.split("/")]).rstrip(".")
        assert f"{place}: 1 more" in capsys.readouterr().err
    assert main(["--update", "--reason", "planted"], root) == 0
    assert main([], root) == 0
    assert 'reason = "planted"' in (root / "budget.toml").read_text()


def test_what_was_saved_is_not_spent_again(root):
    module = root / "tendon_mj" / "module.py"
    module.write_text("import os\n")
    assert main([], root) == 1
    assert main(["--update"], root) == 0
    assert main([], root) == 0
    module.write_text(MODULE)
    assert main([], root) == 1
