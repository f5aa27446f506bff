"""The page in a real browser: it shows the tensions, and its sliders act on the simulation."""

import re
import shutil
import signal
import socket
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from selenium import webdriver
from selenium.webdriver.chrome.service import Service
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.support.ui import WebDriverWait

from tendon_mj.errors import EngineError, MissingPackageError
from tendon_mj.show.live import web
from tendon_mj.show.live.scene_cable import SceneCable, new_scene, scene_cable
from tendon_mj.show.live.sliders import slider
from tendon_mj.show.live.web_cable import row_of_points
from tendon_mj.show.live.web_panel import tension_table
from tests.show.live.models import TENSION, pulled

ROOT = Path(__file__).parents[2]
BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
PATIENCE = 90.0  # for a page on a slow machine [s]
SERVE = """
import sys
from tendon_mj.show.live import serve
from tests.show.live.models import pulled
print(serve(pulled(), port=int(sys.argv[1]), announce=lambda said: print(said, flush=True)))
"""
FLAGS = (
    "--headless=new --no-sandbox --disable-quic --no-first-run --disable-background-networking "
    "--disable-component-update --disable-sync --enable-unsafe-swiftshader --use-angle=swiftshader "
    "--window-size=800,600 --force-device-scale-factor=0.1"  # drawn without a graphics card
)


def free_port():
    with socket.socket() as probe:
        probe.bind(("localhost", 0))
        return probe.getsockname()[1]


@pytest.fixture(scope="module")
def browser(tmp_path_factory):
    program = next(filter(None, map(shutil.which, BROWSERS)), None)
    driver = shutil.which("chromedriver")
    if program is None or driver is None:
        pytest.skip("there is no Chromium with its driver here")
    options = webdriver.ChromeOptions()
    options.binary_location = program
    for flag in FLAGS.split():
        options.add_argument(flag)
    options.add_argument(f"--user-data-dir={tmp_path_factory.mktemp('browser')}")
    found = webdriver.Chrome(options=options, service=Service(driver))
    yield found
    found.quit()


@pytest.fixture
def page(browser):
    """A browser that shows a tendon which is pulled by 10 N, and the process that serves it."""
    pytest.importorskip("mjviser")
    port = free_port()
    server = subprocess.Popen(
        [sys.executable, "-c", SERVE, str(port)],
        cwd=ROOT,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    try:
        while "shows the model" not in (line := server.stdout.readline()):
            assert line, server.stderr.read()
        browser.get(f"http://localhost:{port}")
        WebDriverWait(browser, PATIENCE).until(lambda b: output_tension(b) is not None)
        yield browser, server
    finally:
        server.kill()
        server.communicate()


def output_tension(browser):
    """The tension at the output that the page shows [N], None while it shows none."""
    found = re.search(r"\bt ([\d.]+) ([\d.]+)", browser.find_element(By.TAG_NAME, "body").text)
    return float(found[2]) if found else None


def thumb(browser, label):
    """The part of a slider that is moved."""
    path = f"//*[normalize-space(text())='{label}']/following::*[@role='slider'][1]"
    return browser.find_element(By.XPATH, path)


def test_the_friction_slider_acts_while_the_page_shows_the_tension(page):
    browser, server = page
    WebDriverWait(browser, PATIENCE).until(lambda b: 0.0 < output_tension(b) < 0.9 * TENSION)
    assert browser.find_elements(By.CSS_SELECTOR, ".uplot canvas")
    thumb(browser, "friction").send_keys(Keys.HOME)  # to 0
    WebDriverWait(browser, PATIENCE).until(lambda b: output_tension(b) == pytest.approx(TENSION))
    thumb(browser, "friction").send_keys(Keys.END)
    WebDriverWait(browser, PATIENCE).until(lambda b: thumb(b, "friction").is_displayed())
    server.send_signal(signal.SIGINT)  # as Ctrl-C does
    said, complained = server.communicate(timeout=PATIENCE)
    assert "RealTime(" in said
    assert "Traceback" not in complained
    assert server.returncode == 0


def test_a_port_that_is_taken_is_refused():
    pytest.importorskip("mjviser")
    with socket.socket() as other:
        other.bind(("localhost", 0))
        other.listen()
        with pytest.raises(EngineError, match="is taken; give another by --port"):
            web.serve(pulled(), port=other.getsockname()[1])


def test_without_mjviser_it_is_said_how_to_get_it(monkeypatch):
    monkeypatch.setitem(sys.modules, "mjviser", None)
    with pytest.raises(MissingPackageError, match=r"pip install 'tendon-mj\[web\]'"):
        web.serve(pulled())


def test_the_tensions_are_a_table():
    table = tension_table(["flexor"], np.array([[12.345, 6.0]]), 1.26)
    assert "| flexor | 12.35 | 6.00 |" in table
    assert "time 1.3 s" in table


def test_the_page_shows_what_the_plugin_draws():
    simulation = pulled().simulation
    simulation.advance(0.1)
    cable = scene_cable(simulation.model, simulation.data, new_scene(simulation.model))
    path = simulation.data.wrap_xpos.reshape(-1, 3)
    np.testing.assert_allclose(cable.ends[:, 0], path[[0, 1]], atol=1e-6)
    np.testing.assert_allclose(cable.ends[:, 1], path[[1, 2]], atol=1e-6)
    assert cable.colours.shape == (2, 3)
    assert len(cable.slipping) <= 1


@pytest.mark.parametrize("most", [10, 100, 8000])
def test_a_row_of_points_has_the_ends_and_no_gaps(most):
    ends = np.array([[[0, 0, 0], [1, 0, 0]], [[1, 0, 0], [1, 0, 0]], [[1, 0, 0], [1, 2, 0]]], float)
    colours = np.array([[1, 0, 0], [2, 0, 0], [3, 0, 0]], np.uint8)
    points, shown = row_of_points(SceneCable(ends, colours, np.zeros((0, 3))), 0.01, most)
    assert len(points) == len(shown) <= most + 3
    for k, (start, end) in enumerate(ends):
        own = points[shown[:, 0] == k + 1]
        np.testing.assert_allclose(own[0], start)
        np.testing.assert_allclose(own[-1], end)
    gaps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    assert gaps.max() <= max(0.01, 3.0 / (most - 6)) + 1e-9


def test_no_tendon_is_no_point():
    nothing = SceneCable(np.zeros((0, 2, 3)), np.zeros((0, 3), np.uint8), np.zeros((0, 3)))
    assert not len(row_of_points(nothing, 0.01)[0])


def test_every_live_parameter_of_a_sheath_has_a_slider_that_admits_its_ends():
    simulation = pulled().simulation
    for name, value in dict(simulation.parameters).items():
        parameter = name.partition(".")[2]
        found = slider(parameter, value)
        if found is None:
            assert "radius" in parameter or parameter == "drawn_bend"
            continue
        assert found.low <= value * found.factor <= found.high
        for end in (found.low, found.high, value * found.factor):
            simulation.set(name, end / found.factor)


@pytest.mark.parametrize(
    ("parameter", "value", "label", "high"),
    [
        ("backlash", 0.0, "backlash [mm]", 5.0),
        ("axial_stiffness", 4000.0, "axial stiffness [kN]", 12.0),
        ("sheath_compliance", 0.0, "sheath compliance [µm/N]", 100.0),
        ("extra_bend", 0.0, "extra bend [°]", 180.0),
        ("friction", 0.1, "friction", 0.6),
    ],
)
def test_a_slider_is_in_the_unit_in_which_one_thinks(parameter, value, label, high):
    found = slider(parameter, value)
    assert (found.label, found.high) == (label, pytest.approx(high))
    assert found.value == pytest.approx(found.factor * value)
