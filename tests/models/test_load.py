"""Models of others that cannot be loaded are refused by file and cause."""

import os
import re

import pytest

from tendon_mj.errors import TendonError
from tendon_mj.model_files import files_of_model
from tendon_mj.models import load_model, model_path


def test_a_name_that_is_not_utf_8_says_so(tmp_path):
    text = model_path("bench").read_text("utf-8").replace('"tendon"', '"fléxor"')
    path = tmp_path / "latin.xml"
    path.write_text(text, encoding="latin-1")
    with pytest.raises(TendonError, match=r"latin\.xml: .* byte 0xe9, which is not UTF-8"):
        load_model(str(path))


PLAIN = '<mujoco>{}<worldbody><geom size="1"/></worldbody></mujoco>'
ASSET = '<compiler {}="parts"/><asset><{} name="a" file="pipe.{}"/></asset>'


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="Windows has no named pipes")
@pytest.mark.parametrize(
    ("text", "tag", "file"),
    [
        ('<include file="pipe.xml"/>', "include", "pipe.xml"),
        ("<include\n file = 'pipe&#46;xml' />", "include", "pipe.xml"),
        ('<include file="link.xml"/>', "include", "link.xml"),
        ('<include file="/dev/zero"/>', "include", "/dev/zero"),
        ('<include file="parts/nested.xml"/>', "include", "pipe.xml"),
        ('<include file="parts/deeper.xml"/>', "include", "parts/only.xml"),
        ('<include file="parts/nested.xml"></include', "include", "pipe.xml"),  # broken after it
        (ASSET.format("meshdir", "mesh", "stl"), "mesh", "parts/pipe.stl"),
        (ASSET.format("texturedir", 'texture type="2d"', "png"), "texture", "parts/pipe.png"),
        (ASSET.format("assetdir", "hfield", "png"), "hfield", "parts/pipe.png"),
        ('<asset><model name="m" file="parts/sub.xml"/></asset>', "include", "parts/pipe.xml"),
    ],
)
def test_a_model_made_of_pipes_or_devices_is_refused_and_they_are_not_opened(
    text, tag, file, tmp_path
):
    (tmp_path / "parts").mkdir()
    for name in (
        "pipe.xml",
        "parts/pipe.xml",
        "parts/only.xml",
        "parts/pipe.stl",
        "parts/pipe.png",
    ):
        os.mkfifo(tmp_path / name)
    (tmp_path / "link.xml").symlink_to("pipe.xml")
    nested = '<mujoco><include file="pipe.xml"/></mujoco>'
    (tmp_path / "parts" / "nested.xml").write_text(nested)
    (tmp_path / "parts" / "deeper.xml").write_text('<mujoco><include file="only.xml"/></mujoco>')
    (tmp_path / "parts" / "sub.xml").write_text(nested)
    path = tmp_path / "rig.xml"
    path.write_text(PLAIN.format(text))
    said = rf"rig\.xml: <{tag}> names \S*{re.escape(file)}, which is a device or pipe"
    with pytest.raises(TendonError, match=said):
        load_model(str(path))


def test_includes_in_a_circle_by_ever_longer_paths_are_walked_once(tmp_path):
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "round").symlink_to(".")
    names = ("../parts/circle.xml", "round/circle.xml", "./circle.xml", "\0.xml")
    circle = "".join(f'<include file="{name}"/>' for name in names)
    (tmp_path / "parts" / "circle.xml").write_text(f"<mujoco>{circle}</mujoco>")
    path = tmp_path / "rig.xml"
    path.write_text(PLAIN.format('<include file="parts/circle.xml"/>'))
    with pytest.raises(TendonError, match=r"rig\.xml: XML Error"):
        load_model(str(path))


def test_files_that_are_not_there_and_includes_in_a_circle_are_left_to_mujoco(tmp_path):
    path = tmp_path / "rig.xml"
    for file in ("none.xml", "rig.xml", "a" * 5000, ""):
        path.write_text(PLAIN.format(f'<include file="{file}"/>'))
        with pytest.raises(TendonError, match=r"rig\.xml: XML Error"):
            load_model(str(path))


def test_a_name_that_no_file_can_have_is_no_file_of_a_model(tmp_path):
    names = ("a" * 5000, "a\\0b", "gone.stl", ".")
    elements = "".join(f"<mesh name='m{k}' file='{name}'/>" for k, name in enumerate(names))
    path = tmp_path / "m.xml"
    path.write_text(f"<mujoco><asset>{elements}</asset></mujoco>")
    assert files_of_model(path) == [path]


def test_what_a_comment_names_is_no_file_of_a_model(tmp_path):
    for name in ("other.xml", "a.png"):
        (tmp_path / name).write_text("<mujoco/>")
    path = tmp_path / "m.xml"
    path.write_text('<mujoco><!-- as in <include file="other.xml"/>, a.png --></mujoco>')
    assert files_of_model(path) == [path]


@pytest.mark.parametrize("strips", [False, True])
def test_a_path_is_stripped_only_where_the_model_says_so(tmp_path, strips):
    (tmp_path / "tex").mkdir()
    places = [tmp_path / "tex" / "a.png", tmp_path / "a.png"]
    for place in places:
        place.touch()
    path = tmp_path / "m.xml"
    compiler = f'<compiler strippath="{str(strips).lower()}"/>'
    path.write_text(f'<mujoco>{compiler}<asset><texture file="tex/a.png"/></asset></mujoco>')
    assert files_of_model(path) == [path, places[strips]]
