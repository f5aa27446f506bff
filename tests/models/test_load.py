"""Models of others that cannot be loaded are refused by file and cause."""

import pytest

from tendon_mj.errors import TendonError
from tendon_mj.model_files import files_of_model
from tendon_mj.models import load_model
from tests.refusals import refusing


@pytest.mark.parametrize("file", ["none.xml", "rig.xml", ""])
def test_missing_and_circular_includes_are_left_to_mujoco(file, tmp_path):
    path = tmp_path / "rig.xml"
    path.write_text(f'<mujoco><include file="{file}"/></mujoco>')
    with refusing(TendonError, "rig.xml"):
        load_model(str(path))


def test_a_file_that_is_no_model_is_refused_with_what_is_one(tmp_path):
    path = tmp_path / "rig.toml"
    path.write_text("[recording]")
    with refusing(TendonError, "rig.toml", "MJCF"):
        load_model(str(path))


def test_the_files_of_a_model_are_those_that_it_includes_or_attaches(tmp_path):
    texts = {
        "main.xml": "<include\n file = 'parts/a&#46;xml' /><model name='m' file=\"sub/child.xml\"/>"
        '<include file="main.xml"/><include file="gone.xml"/>'
        '<!-- as in <include file="other.xml"/> --><mesh file="mesh.stl"/>',
        "other.xml": "",
        "parts/a.xml": '<include file="b.xml"/><include file="../main.xml"/>',
        "parts/b.xml": "",
        "sub/child.xml": '<include file="c.xml"/>',
        "sub/c.xml": "</broken",
        "mesh.stl": "",
    }
    for name, text in texts.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(f"<mujoco>{text}</mujoco>")
    names = ("main.xml", "parts/a.xml", "parts/b.xml", "sub/child.xml", "sub/c.xml")
    files = files_of_model(tmp_path / "main.xml")
    assert sorted(files) == sorted(tmp_path / name for name in names)
