"""A simulation in a window and on a page: numbers, curves, sliders, and `tendon-mj view`."""

import os
import platform
import re
import shutil
import signal
import socket
import subprocess
import sys
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path

import mujoco
import numpy as np
import pytest
from PIL import Image
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.support.ui import WebDriverWait

from tendon_mj.errors import EngineError
from tendon_mj.lab.units import force_unit
from tendon_mj.models import load_model
from tendon_mj.show.live import open_window, prepare, serve
from tendon_mj.show.live.scene import (
    MOST_TENDONS,
    control_slider,
    drawn_tendons,
    reading_table,
    slider,
    tension_table,
    tension_text,
)
from tendon_mj.show.live.web import row_of_points
from tendon_mj.show.live.window import draw_curves, new_curves
from tests.show.rigs import PULLED, TENSION, pulled, start_browser

ROOT = Path(__file__).parents[2]
PATIENCE = 90.0  # for a page on a slow machine [s]
SERVE = """
import signal, sys
signal.signal(signal.SIGINT, signal.default_int_handler)  # which a shell's & leaves to the parent
from tendon_mj.show.live import serve
from tests.show.rigs import pulled
print(serve(pulled(), port=int(sys.argv[1]), announce=lambda text: print(text, flush=True)))
"""
SERVE_TURNING = """
import sys
import mujoco, numpy as np
from tendon_mj.show.live import LiveSimulation, Prepared, serve
from tendon_mj.show.live.scene import first_view
from tests.show.test_view import TURNING
model = mujoco.MjModel.from_xml_string(TURNING)
simulation = LiveSimulation(model, lambda time: np.array([5.0]))
shown = Prepared(simulation, first_view(model), 0.0, 0.0, "")
serve(shown, port=int(sys.argv[1]), announce=lambda text: print(text, flush=True))
"""
TURNING = """<mujoco>  <!-- a translucent bar with a blue tendon along it -->
  <option gravity="0 0 0"/>
  <worldbody>
    <camera name="front" pos="0 -1 0" xyaxes="1 0 0 0 0 1" fovy="50"/>
    <body>
      <joint name="turn" axis="0 1 0"/>
      <geom type="capsule" fromto="-.2 0 0 .2 0 0" size=".05" mass="1" rgba="0 1 0 .5"/>
      <site name="a" pos="-.2 0 0"/>
      <site name="b" pos=".2 0 0"/>
    </body>
  </worldbody>
  <tendon>
    <spatial name="t" width=".01" rgba="0 0 1 1"><site site="a"/><site site="b"/></spatial>
  </tendon>
  <actuator><velocity joint="turn" kv="10" ctrlrange="-9 9"/></actuator>
</mujoco>"""
OPEN = """
import sys
from tendon_mj.show.live import open_window
from tests.show.rigs import pulled
try:
    open_window(pulled())
except Exception as error:
    sys.exit(str(error))
"""
FLAGS = (
    "--headless=new --enable-unsafe-swiftshader --use-angle=swiftshader "
    "--window-size=1280,800 --force-device-scale-factor=0.1"  # drawn without a graphics card
)


def test_tensions_are_numbers_with_units_and_of_many_tendons_the_others_are_counted():
    flexor = ["flexor"], np.array([[12.345, 5.67]])
    left, right = tension_text(*flexor, 3.21)
    assert left.splitlines() == ["time [s]", "flexor: input to output tension [N]"]
    assert right.splitlines() == ["3.2", "12.3 to 5.7"]
    assert "| flexor | 12.35 | 5.67 |" in tension_table(*flexor, 3.21)
    small = ["flexor"], np.array([[0.0123, 0.0056]]), 3.21, force_unit([0.02])
    assert [column.splitlines()[1] for column in tension_text(*small)] == [
        "flexor: input to output tension [mN]",
        "12.3 to 5.6",
    ]
    assert "input [mN]" in tension_table(*small)
    large = ["rope"], np.array([[4e5, 2e5]]), 3.21, force_unit([4e5])
    assert "rope: input to output tension [kN]" in tension_text(*large)[0]
    assert "| rope | 400.00 | 200.00 |" in tension_table(*large)
    assert "| flexor | 12.30 | 5.60 |" in tension_table(*small)
    left, right = tension_text([f"t{k}" for k in range(39)], np.ones((39, 2)), 0.0)
    assert len(left.splitlines()) == MOST_TENDONS + 2
    assert f"and {39 - MOST_TENDONS} more tendons" in left
    assert right.count("to") == MOST_TENDONS


@pytest.mark.parametrize("count", [1, 10, 3000])
def test_the_curves_are_the_tensions(count):
    times = np.linspace(0.0, 20.0, count)
    tensions = np.stack([np.sin(times) + 2.0, np.cos(times) + 2.0], axis=1)[:, None]
    figure = new_curves(np.zeros((1, 2, 3)), 20.0)
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


def test_a_tension_without_bound_leaves_the_figure_finite():
    figure = new_curves(np.zeros((1, 2, 3)), 20.0)
    draw_curves(figure, np.array([0.0]), np.array([[[np.inf, np.nan]]]), 8.0)
    assert np.isfinite(figure.linedata[:2]).all()


def test_numbers_of_joints_and_touch_have_units():
    simulation = prepare("finger", "press").simulation
    simulation.advance(2.5)
    table = reading_table(simulation.model, simulation.data)
    assert "mcp [°]" in table
    assert "object [mm]" in table
    force = float(re.search(r"tip force \[N\] \| ([\d.]+)", table)[1])
    sensor = simulation.model.sensor("tip_force").adr[0]
    assert force == pytest.approx(simulation.data.sensordata[sensor], abs=0.006)
    first = simulation.model.joint("mcp").qposadr[0]
    for place, said in ((-7.2, "−7.2"), (7.2, "7.2"), (-0.01, "0.0")):  # never −0
        simulation.data.qpos[first] = np.radians(place)
        assert f"| mcp [°] | {said} |" in reading_table(simulation.model, simulation.data)
    assert reading_table(mujoco.MjModel.from_xml_string("<mujoco/>"), None) == ""


def test_a_control_has_a_slider_over_its_range_in_an_engineer_s_unit():
    model = load_model("joint")
    shown = control_slider(model, model.actuator("reel_1").id, 1e-3)
    assert (shown.label, shown.value) == ("reel_1 [mm]", pytest.approx(1.0))
    assert shown.low <= -1.0 < 1.0 <= shown.high
    ranged = pulled().simulation.model
    ranged.actuator_ctrllimited[0], ranged.actuator_ctrlrange[0] = True, (0.0, 30.0)
    assert control_slider(ranged, 0, 99.0)[2:4] == (0.0, 30.0)
    assert control_slider(ranged, 0, 99.0).value == 30.0
    ranged.actuator_ctrlrange[0] = 0.0, 0.03
    for tension, label, high in ((0.02, "pull [mN]", 30.0), (2.0, "pull [N]", 0.03)):
        shown = control_slider(ranged, 0, 0.0, force_unit([tension]))
        assert (shown.label, shown.high) == (label, high), "as the tensions beside it"


def test_without_a_screen_the_browser_is_named(monkeypatch):
    monkeypatch.setattr("platform.system", lambda: "Linux")
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    with pytest.raises(EngineError, match=r"no screen.*--web"):
        open_window(pulled())


@pytest.mark.skipif(platform.system() != "Linux", reason="only Linux has such screens")
def test_a_missing_screen_is_refused_instead_of_waited_for():
    there = {k: v for k, v in os.environ.items() if k != "WAYLAND_DISPLAY"} | {"DISPLAY": ":4711"}
    command = [sys.executable, "-c", OPEN]
    done = subprocess.run(command, env=there, cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 1
    assert "the screen cannot be opened" in done.stderr


def free_port():
    with socket.socket() as probe:
        probe.bind(("localhost", 0))
        return probe.getsockname()[1]


@pytest.fixture(scope="module")
def browser(tmp_path_factory):
    browser = start_browser(tmp_path_factory.mktemp("browser"), FLAGS, {})
    yield browser
    browser.quit()


@contextmanager
def serving(browser, code):
    """A process that serves a page, which the browser shows."""
    pytest.importorskip("mjviser")
    port = free_port()
    server = subprocess.Popen(
        [sys.executable, "-c", code, str(port)],
        cwd=ROOT,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    try:
        while "shows the model" not in (line := server.stdout.readline()):
            assert line, server.stderr.read()
        browser.get(f"http://localhost:{port}")
        WebDriverWait(browser, PATIENCE).until(
            lambda b: b.find_elements(By.XPATH, "//*[@role='tab'][normalize-space()='numbers']")
        )
        yield server
    finally:
        server.kill()
        server.communicate()


@pytest.fixture
def page(browser):
    """A browser that shows a tendon which is pulled by 10 N, and the process that serves it."""
    with serving(browser, SERVE) as server:
        tab(browser, "numbers").click()
        WebDriverWait(browser, PATIENCE).until(lambda b: output_tension(b) is not None)
        yield browser, server


def output_tension(browser):
    """The tension at the output that the page shows [N], or None."""
    row = re.search(r"\bt ([\d.]+) ([\d.]+)", browser.find_element(By.TAG_NAME, "body").text)
    return float(row[2]) if row else None


def tab(browser, label):
    return browser.find_element(By.XPATH, f"//*[@role='tab'][normalize-space()='{label}']")


def thumb(browser, label):
    """The part of a slider that is moved."""
    text = f"//*[normalize-space(text())='{label}'][not(ancestor-or-self::*[@role='tab'])]"
    path = f"{text}/following::*[@role='slider'][1]"
    return browser.find_element(By.XPATH, path)


def test_the_friction_slider_acts_while_the_page_shows_the_tension(page):
    browser, server = page
    WebDriverWait(browser, PATIENCE).until(lambda b: 0.0 < output_tension(b) < 0.9 * TENSION)
    assert browser.find_elements(By.CSS_SELECTOR, ".uplot canvas")
    tab(browser, "friction").click()
    thumb(browser, "friction").send_keys(Keys.HOME)  # to 0
    tab(browser, "numbers").click()
    WebDriverWait(browser, PATIENCE).until(lambda b: output_tension(b) == pytest.approx(TENSION))
    tab(browser, "friction").click()
    thumb(browser, "friction").send_keys(Keys.END)
    WebDriverWait(browser, PATIENCE).until(lambda b: thumb(b, "friction").is_displayed())
    server.send_signal(signal.SIGINT)  # as Ctrl-C does
    output, errors = server.communicate(timeout=PATIENCE)
    assert "RealTime(" in output
    assert "Traceback" not in errors
    assert server.returncode == 0


def test_the_page_is_halted_goes_on_and_is_moved_by_hand(page):
    browser, _ = page

    def button(label):
        return browser.find_element(By.XPATH, f"//button[normalize-space()='{label}']")

    button("pause").click()
    WebDriverWait(browser, PATIENCE).until(lambda b: button("resume").is_displayed())
    button("resume").click()
    tab(browser, "motion").click()
    thumb(browser, "pull [N]").send_keys(Keys.HOME)  # to -5 N: a cable cannot push
    tab(browser, "numbers").click()
    WebDriverWait(browser, PATIENCE).until(lambda b: output_tension(b) == 0.0)


def test_a_translucent_body_and_the_tendon_in_it_turn_together_on_the_page(browser):
    def turned(seen):
        """Direction in which the pixels that are seen lie [rad]."""
        points = np.argwhere(seen) - np.argwhere(seen).mean(axis=0)
        return np.arctan2(*np.linalg.eigh(points.T @ points)[1][:, 1])

    def apart():
        """Angle between body and tendon [deg], or None before both are drawn."""
        image = np.array(Image.open(BytesIO(browser.get_screenshot_as_png())).convert("RGB"), int)
        height, width = image.shape[:2]
        scene = image[height // 5 :, width // 8 : width // 2]  # without the panels
        is_body, is_tendon = (scene[..., k] > scene[..., 3 - k] + 8 for k in (1, 2))
        if min(is_body.sum(), is_tendon.sum()) < 20:
            return None
        return np.degrees(np.arcsin(abs(np.sin(turned(is_body) - turned(is_tendon)))))

    size = {"width": 1280, "height": 800, "deviceScaleFactor": 0.3, "mobile": False}
    with serving(browser, SERVE_TURNING):
        browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
        try:
            WebDriverWait(browser, PATIENCE).until(lambda b: apart() is not None)
            angles = [apart() for _ in range(30)]
        finally:
            browser.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})
    assert max(angles) < 5.0, np.round(angles, 1)


def test_the_page_shows_what_the_plugin_draws():
    simulation = pulled().simulation
    simulation.advance(0.1)
    scene = mujoco.MjvScene(simulation.model, 100)
    ends, colours, slipping = drawn_tendons(simulation.model, simulation.data, scene)
    path = simulation.data.wrap_xpos.reshape(-1, 3)
    np.testing.assert_allclose(ends[:, 0], path[[0, 1]], atol=1e-6)
    np.testing.assert_allclose(ends[:, 1], path[[1, 2]], atol=1e-6)
    assert colours.shape == (2, 3)
    assert len(slipping) <= 1


def test_a_tendon_without_a_tension_scale_is_shown_in_its_own_colour():
    model = mujoco.MjModel.from_xml_string(PULLED)
    model.tendon_rgba[0] = 0.2, 0.4, 0.6, 1.0
    data, scene = mujoco.MjData(model), mujoco.MjvScene(model, 100)
    mujoco.mj_forward(model, data)
    ends, colours, slipping = drawn_tendons(model, data, scene)
    path = data.wrap_xpos.reshape(-1, 3)
    np.testing.assert_allclose(ends, [path[[0, 1]], path[[1, 2]]], atol=1e-6)
    np.testing.assert_array_equal(colours, [[51, 102, 153]] * 2)
    assert not len(slipping)


def test_a_driven_tendon_has_a_page_without_a_slider_for_its_pretension():
    pytest.importorskip("mjviser")
    prepared = pulled()
    assert "sheath.pretension" not in prepared.simulation.parameters
    done = serve(prepared, port=free_port(), seconds=0.1, announce=lambda text: None)
    assert done.frames > 0


@pytest.mark.parametrize("most", [10, 100, 8000])
def test_a_row_of_points_has_the_ends_and_no_gaps(most):
    ends = np.array([[[0, 0, 0], [1, 0, 0]], [[1, 0, 0], [1, 0, 0]], [[1, 0, 0], [1, 2, 0]]], float)
    colours = np.array([[1, 0, 0], [2, 0, 0], [3, 0, 0]], np.uint8)
    points, shown = row_of_points(ends, colours, 0.01, most)
    assert len(points) == len(shown) <= most + 3
    for k, (start, end) in enumerate(ends):
        own = points[shown[:, 0] == k + 1]
        np.testing.assert_allclose(own[0], start)
        np.testing.assert_allclose(own[-1], end)
    gaps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    assert gaps.max() <= max(0.01, 3.0 / (most - 6)) + 1e-9


def test_every_live_parameter_of_a_sheath_has_a_slider_that_admits_its_ends():
    simulation = pulled().simulation
    for name, value in dict(simulation.parameters).items():
        parameter = name.partition(".")[2]
        shown = slider(parameter, value)
        if shown is None:
            assert "radius" in parameter
            continue
        assert shown.low <= value * shown.factor <= shown.high
        for end in (shown.low, shown.high, value * shown.factor):
            simulation.set(name, end / shown.factor)


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
def test_a_slider_is_in_an_engineer_s_unit(parameter, value, label, high):
    shown = slider(parameter, value)
    assert (shown.label, shown.high) == (label, pytest.approx(high))
    assert shown.value == pytest.approx(shown.factor * value)


def view(*arguments, **environment):
    command = [sys.executable, "-m", "tendon_mj", "view", *arguments]
    return subprocess.run(
        command,
        env={**os.environ, **environment},
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=2.0 * PATIENCE,
    )


@pytest.fixture
def screen():
    """Name of a virtual screen."""
    program = shutil.which("Xvfb")
    if program is None:
        pytest.skip("there is no Xvfb here")
    reads, writes = os.pipe()
    flags = ["-displayfd", str(writes), "-screen", "0", "800x600x24", "+extension", "GLX"]
    server = subprocess.Popen([program, *flags], pass_fds=[writes], stderr=subprocess.DEVNULL)
    os.close(writes)
    with os.fdopen(reads) as number:
        yield f":{number.readline().strip()}"
    server.terminate()
    server.wait()


def test_a_window_opens_and_reports_its_pace(screen):
    done = view("finger", "--seconds", "2", DISPLAY=screen, LIBGL_ALWAYS_SOFTWARE="1")
    if "could not open" in done.stderr or "GLX" in done.stderr:
        pytest.skip(f"nothing can be drawn on that screen: {done.stderr}")
    assert done.returncode == 0, done.stderr
    assert "× real time" in done.stdout
    assert not done.stderr


def test_a_page_is_served_for_a_given_time():
    pytest.importorskip("mjviser")
    done = view("bench", "--web", "--port", str(free_port()), "--seconds", "1")
    assert done.returncode == 0, done.stderr
    *_, first, last = done.stdout.splitlines()
    assert first.startswith("http://localhost:")
    assert "× real time" in last
