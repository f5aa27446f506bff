"""Without OpenGL the error says what to do."""

import os
import subprocess
import sys

import pytest

from tendon_mj.errors import EngineError
from tendon_mj.show.render.offscreen import gl_platforms
from tests.refusals import refusing

SCRIPT = """
import os, sys
import mujoco
if sys.argv[1:]:
    os.environ["MUJOCO_GL"] = sys.argv[1]
from tendon_mj.errors import EngineError
from tendon_mj.show.render.offscreen import Offscreen, find_camera
model = mujoco.MjModel.from_xml_string("<mujoco><worldbody><geom size='.1'/></worldbody></mujoco>")
try:
    with Offscreen(model, 64, 64) as offscreen:
        image = offscreen.draw(mujoco.MjData(model), find_camera(model, None))
        print("drawn", image.shape)
except EngineError as error:
    print("refused:", error)
"""


def draw_without_a_screen(*late, **variables):
    keep = {
        k: v for k, v in os.environ.items() if k not in ("DISPLAY", "WAYLAND_DISPLAY", "MUJOCO_GL")
    }
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT, *late],
        env=keep | variables,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert "Traceback" not in done.stderr
    return done.stdout


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere GLFW needs no DISPLAY")
@pytest.mark.parametrize(("late", "early"), [((), {"MUJOCO_GL": "glfw"}), (("glfw",), {})])
def test_glfw_without_a_screen_is_refused_with_advice(late, early):
    output = draw_without_a_screen(*late, **early)
    assert output.startswith("refused: no OpenGL to draw with, tried glfw")
    assert "DISPLAY" in output
    assert "MUJOCO_GL" in output


@pytest.mark.skipif(sys.platform != "linux", reason="EGL is Linux's way")
def test_no_variable_has_to_be_set_before_mujoco_is_imported(gl):
    assert draw_without_a_screen() == "drawn (64, 64, 3)\n"


def test_a_given_platform_is_the_only_one_tried(monkeypatch):
    monkeypatch.setenv("MUJOCO_GL", "OSMesa")
    assert gl_platforms() == ("osmesa",)
    monkeypatch.setenv("MUJOCO_GL", "off")
    with refusing(EngineError, "turns drawing off"):
        gl_platforms()
