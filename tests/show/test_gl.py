"""Without OpenGL there is a word on what to do, and never a crash."""

import os
import subprocess
import sys

import pytest

from tendon_mj.errors import EngineError
from tendon_mj.show.render.gl import gl_platforms, make_context

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
    said = draw_without_a_screen(*late, **early)
    assert said.startswith("refused: no OpenGL to draw with, tried glfw")
    assert "DISPLAY" in said
    assert "MUJOCO_GL" in said


@pytest.mark.skipif(sys.platform != "linux", reason="EGL is Linux's way")
def test_no_variable_has_to_be_set_before_mujoco_is_imported(gl):
    assert draw_without_a_screen() == "drawn (64, 64, 3)\n"


@pytest.mark.parametrize("value", ["off", "0", "disabled"])
def test_drawing_that_is_turned_off_is_said_to_be(monkeypatch, value):
    monkeypatch.setenv("MUJOCO_GL", value)
    with pytest.raises(EngineError, match=f"MUJOCO_GL={value} turns drawing off"):
        gl_platforms()


def test_an_unknown_platform_is_answered_with_the_nearest(monkeypatch):
    monkeypatch.setenv("MUJOCO_GL", "elg")
    with pytest.raises(EngineError, match="did you mean 'egl'"):
        gl_platforms()


def test_the_platform_that_was_asked_for_is_the_only_one_tried(monkeypatch):
    monkeypatch.setenv("MUJOCO_GL", "OSMesa")
    assert gl_platforms() == ("osmesa",)


def test_a_library_that_is_missing_is_said_to_be(monkeypatch):
    def not_there(module):
        raise AttributeError("'NoneType' object has no attribute 'eglQueryString'")

    monkeypatch.setenv("MUJOCO_GL", "egl")
    monkeypatch.setattr("tendon_mj.show.render.gl.importlib.import_module", not_there)
    with pytest.raises(
        EngineError, match=r"egl \(its library was not found\).*apt install libegl1"
    ):
        make_context(64, 64)
