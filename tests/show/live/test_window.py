"""What the viewer shows beside a model: numbers, curves and a key of colours."""

import os
import platform
import subprocess
import sys
from pathlib import Path

import mujoco
import numpy as np
import pytest

from tendon_mj.errors import EngineError
from tendon_mj.show.live import open_window
from tendon_mj.show.live.colour_key import colour_key, key_height
from tendon_mj.show.live.curve_colours import curve_colours
from tendon_mj.show.live.window_overlay import (
    MOST,
    curves_place,
    draw_curves,
    key_place,
    new_figure,
    tension_text,
)
from tests.show.live.models import pulled

ROOT = Path(__file__).parents[2]


def test_tensions_are_shown_as_numbers_with_units():
    left, right = tension_text(["flexor"], np.array([[12.34, 5.67]]), 3.21)
    assert left.splitlines() == ["time [s]", "flexor: input to output tension [N]"]
    assert right.splitlines() == ["3.2", "12.3 to 5.7"]


def test_of_many_tendons_the_first_are_shown_and_the_others_counted():
    left, right = tension_text([f"t{k}" for k in range(39)], np.ones((39, 2)), 0.0)
    assert len(left.splitlines()) == MOST + 2
    assert f"and {39 - MOST} more tendons" in left
    assert right.count("to") == MOST


@pytest.mark.parametrize("count", [1, 10, 3000])
def test_the_curves_are_the_tensions(count):
    times = np.linspace(0.0, 20.0, count)
    tensions = np.stack([np.sin(times) + 2.0, np.cos(times) + 2.0], axis=1)[:, None]
    figure = new_figure(np.zeros((1, 2, 3)), 20.0)
    draw_curves(figure, times, tensions, 8.0)
    for end in (0, 1):
        points = figure.linepnt[end]
        assert points == min(count, 1000)
        line = figure.linedata[end, : 2 * points].reshape(-1, 2)
        np.testing.assert_allclose(line[:, 0], times[-points:], rtol=1e-6)
        np.testing.assert_allclose(line[:, 1], tensions[-points:, 0, end], rtol=1e-6)
    low, high = figure.range[0]
    assert high - low == pytest.approx(8.0)
    assert low <= times[-1] <= high + 1e-5


def test_a_tension_without_bound_breaks_no_figure():
    figure = new_figure(np.zeros((1, 2, 3)), 20.0)
    draw_curves(figure, np.array([0.0]), np.array([[[np.inf, np.nan]]]), 8.0)
    assert np.isfinite(figure.linedata[:2]).all()


def test_curves_and_key_lie_within_the_window_and_apart():
    window = mujoco.MjrRect(0, 0, 853, 533)
    curves, key = curves_place(window), key_place(window, key_height(2))
    for place in (curves, key):
        assert place.left >= 0
        assert place.bottom >= 0
        assert place.left + place.width <= window.width
        assert place.bottom + place.height <= window.height
    assert key.left + key.width <= curves.left


def test_each_tendon_has_the_colour_that_the_model_gives_it():
    model = pulled().simulation.model
    model.tendon_rgba[0] = 0.8, 0.2, 0.1, 1.0
    full, pale = curve_colours(model)[0]
    np.testing.assert_allclose(full, [0.8, 0.2, 0.1], atol=1e-6)
    assert (pale >= full).all()


def test_the_key_of_colours_has_all_of_them():
    colours = np.array([[[1.0, 0.0, 0.0], [1.0, 0.6, 0.6]]])
    picture = colour_key((0.0, 20.0), ["t"], colours, 420, key_height(1))
    assert picture.shape == (key_height(1), 420, 3)
    seen = {tuple(pixel) for pixel in picture.reshape(-1, 3)}
    for colour in ((68, 1, 84), (253, 231, 37), (255, 0, 0), (255, 153, 153)):
        assert min(np.abs(np.subtract(pixel, colour)).max() for pixel in seen) <= 4


def test_without_a_screen_the_browser_is_named(monkeypatch):
    monkeypatch.setattr("platform.system", lambda: "Linux")
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    with pytest.raises(EngineError, match=r"no screen.*--web"):
        open_window(pulled())


@pytest.mark.skipif(platform.system() != "Linux", reason="only Linux has such screens")
def test_a_screen_that_is_not_there_is_refused_instead_of_waited_for():
    code = "import sys\nfrom tendon_mj.show.live import open_window\n"
    code += "from tests.show.live.models import pulled\n"
    code += "try:\n    open_window(pulled())\nexcept Exception as error:\n    sys.exit(str(error))"
    there = {**os.environ, "DISPLAY": ":4711"}
    there.pop("WAYLAND_DISPLAY", None)
    done = subprocess.run(
        [sys.executable, "-c", code], env=there, cwd=ROOT, capture_output=True, text=True
    )
    assert done.returncode == 1
    assert "the screen cannot be opened; `tendon-mj view MODEL --web`" in done.stderr
