"""A file is written whole or not at all, and an error names it."""

import pytest

from tendon_mj.whole_file import whole_file


def test_the_new_text_replaces_the_old(tmp_path):
    path = tmp_path / "picture.png"
    path.write_text("old")
    with whole_file(path) as made:
        assert made.suffix == ".png"  # writers choose the format by it
        made.write_text("new")
        assert path.read_text() == "old"
    assert path.read_text() == "new"
    assert list(tmp_path.iterdir()) == [path]


def test_a_failure_leaves_the_old_text_and_nothing_else(tmp_path):
    path = tmp_path / "clip.mp4"
    path.write_text("old")

    def fail():
        with whole_file(path) as made:
            made.write_text("half")
            raise RuntimeError

    with pytest.raises(RuntimeError):
        fail()
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_a_missing_folder_is_an_error_that_names_the_file_itself(tmp_path):
    path = tmp_path / "none" / "result.json"
    with pytest.raises(FileNotFoundError) as raised, whole_file(path) as made:
        made.write_text("new")
    assert raised.value.filename == str(path)


def test_a_folder_is_not_replaced(tmp_path):
    (tmp_path / "taken").mkdir()
    with pytest.raises(OSError), whole_file(tmp_path / "taken") as made:  # noqa: PT011
        made.touch()
    assert [path.name for path in tmp_path.iterdir()] == ["taken"]
