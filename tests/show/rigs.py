"""A tendon over one guide, pulled by a motor of given input tension; a browser."""

import shutil

import mujoco
import numpy as np
import pytest
from selenium import webdriver
from selenium.webdriver.chrome.service import Service

import tendon_mj
from tendon_mj.show.live.scene import first_view
from tendon_mj.show.live.session import LiveSimulation, Prepared
from tests.rigs import pulled_xml

CAMERA = '<camera name="front" pos="0.5 -1.2 0.1" xyaxes="1 0 0 0 0 1" fovy="50"/>'
PULLED = pulled_xml(world=CAMERA)
TENSION = 10.0
BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
FLAGS = (
    "--no-sandbox --disable-quic --no-first-run --disable-background-networking "
    "--disable-component-update --disable-sync"
)


def pulled(drive=lambda time: np.array([TENSION]), friction=0.3):
    """A tendon that is pulled by 10 N, or by another drive, ready to be shown."""
    spec = mujoco.MjSpec.from_string(PULLED)
    tendon_mj.add_friction(spec, "t", friction=friction)
    model = tendon_mj.show_tension(spec, 0.0, 20.0).compile()
    return Prepared(LiveSimulation(model, drive), first_view(model), 0.0, 20.0, "")


def start_browser(profile, flags, logs):
    """A Chromium with its driver; skips where there is none."""
    program = next(filter(None, map(shutil.which, BROWSERS)), None)
    driver = shutil.which("chromedriver")
    if program is None or driver is None:
        pytest.skip("there is no Chromium with its driver here")
    options = webdriver.ChromeOptions()
    options.binary_location = program
    for flag in (*FLAGS.split(), *flags.split(), f"--user-data-dir={profile}"):
        options.add_argument(flag)
    options.set_capability("goog:loggingPrefs", logs)
    return webdriver.Chrome(options=options, service=Service(driver))
