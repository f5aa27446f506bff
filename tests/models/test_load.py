"""Models of others that cannot be loaded are refused by file and cause."""

import pytest

from tendon_mj.errors import TendonError
from tendon_mj.model_files import files_of_model
from tendon_mj.models import load_model
from tests.refusals import refusing


@pytest.mark.parametrize("included", ["none.xml", "rig.xml", "", None])
def test_a_file_that_is_no_model_is_refused_by_its_name(included, tmp_path):
    path = tmp_path / ("rig.toml" if included is None else "rig.xml")
    path.write_text(f'<mujoco><include file="{included}"/></mujoco>')
    with refusing(TendonError, path.name):
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
