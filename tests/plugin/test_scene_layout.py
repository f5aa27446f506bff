"""A MuJoCo whose scenes are not as described is refused before anything is drawn."""

import mujoco
import pytest

from tendon_mj.errors import EngineError
from tendon_mj.plugin.abi import scene_layout as layouts
from tendon_mj.plugin.abi.scene_layout import read_scene_layout, verify_scene

LAYOUT = read_scene_layout()


def test_the_running_mujoco_is_as_described():
    verify_scene(LAYOUT)


@pytest.mark.parametrize("field", [f for f in LAYOUT._fields if f != "v_flags"])
@pytest.mark.parametrize("shift", [4, -4])
def test_a_wrong_offset_is_refused_by_name(field, shift):
    wrong = LAYOUT._replace(**{field: getattr(LAYOUT, field) + shift})
    with pytest.raises(EngineError, match=f"{mujoco.__version__}: .* is not as its description"):
        verify_scene(wrong)


def test_a_field_that_is_gone_is_refused_by_name(monkeypatch):
    whole = layouts.mirror
    monkeypatch.setattr(
        layouts, "mirror", lambda name: object if name == "mjvScene" else whole(name)
    )
    monkeypatch.setattr(layouts.ctypes, "sizeof", lambda kind: 1)
    with pytest.raises(EngineError, match=r"has no mjvScene\.maxgeom, which tendon-mj draws by"):
        read_scene_layout()
