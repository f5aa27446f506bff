"""The report in a browser: what it draws, at two widths and in two themes."""

import json
from dataclasses import replace

import pytest

from tendon_mj.lab.diagnosis import diagnose
from tendon_mj.show import write_report
from tests.lab.diagnosis.toy import Toy, rig
from tests.show.rigs import start_browser

VIEWPORTS = {1280: 800, 390: 844}
NAME = "<img src=x onerror='window.broken=1'>"
# elements that reach beyond the viewport, but for what scrolls inside a wrapper
TOO_WIDE = """
const width = document.documentElement.clientWidth;
return [...document.querySelectorAll("body *")]
  .filter((e) => !e.closest(".scroll *"))
  .filter((e) => e.getBoundingClientRect().right > width + 0.5)
  .map((e) => e.outerHTML.slice(0, 80));
"""


@pytest.fixture(scope="module")
def browser(tmp_path_factory):
    logs = {"browser": "ALL", "performance": "ALL"}
    profile = tmp_path_factory.mktemp("browser")
    browser = start_browser(profile, "--headless --disable-gpu", logs)
    yield browser
    browser.quit()


@pytest.fixture(scope="module")
def reports(tmp_path_factory):
    """Verdict → its page, with names that are markup."""
    pages = {}
    for truth, extra in (("sheath.constant_friction", 0.0), (None, 0.0), (None, 1.0)):
        train, held_out = rig(1, {"sheath.friction": 0.2} | ({truth: 1.0} if truth else {}), extra)
        held_out = [replace(r, name=f"{NAME} {k}", source=NAME) for k, r in enumerate(held_out)]
        result = diagnose(train, held_out, Toy)
        folder = tmp_path_factory.mktemp("report")
        (folder / "model.xml").write_text("<mujoco/>")
        pages[result.verdict] = write_report(result, result.simulate(), folder)[-1]
    assert pages.keys() == {"named", "nothing missing", "unknown"}
    return pages


def load(browser, page, width, theme):
    """Open a page, and return the browser's errors and its requests to a network."""
    metrics = {"width": width, "height": VIEWPORTS[width], "deviceScaleFactor": 1, "mobile": False}
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)
    feature = {"name": "prefers-color-scheme", "value": theme}
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": [feature]})
    browser.get_log("browser")
    browser.get_log("performance")
    browser.get(page.as_uri())
    errors = [entry["message"] for entry in browser.get_log("browser")]
    events = [json.loads(entry["message"])["message"] for entry in browser.get_log("performance")]
    requests = [
        event["params"]["request"]["url"]
        for event in events
        if event["method"] == "Network.requestWillBeSent"
    ]
    local = ("file:", "data:", "blob:", "chrome:")  # the last is its own empty tab
    return errors, [url for url in requests if not url.startswith(local)]


@pytest.mark.parametrize("theme", ["light", "dark"])
@pytest.mark.parametrize("width", VIEWPORTS)
def test_a_report_is_drawn_whole_and_asks_nobody(browser, reports, width, theme):
    errors, requests = load(browser, reports["named"], width, theme)
    assert not errors
    assert not requests
    assert not browser.execute_script(TOO_WIDE)
    assert browser.execute_script("return document.documentElement.scrollWidth") <= width
    assert browser.execute_script("return window.broken") is None
    drawn = "return [...document.querySelectorAll('figure img')].every(i => i.naturalWidth > 0)"
    assert browser.execute_script(drawn)
    if width < 1000:  # what does not fit scrolls
        tables = "[...document.querySelectorAll('.scroll')]"
        wide = f"return {tables}.some(e => e.scrollWidth > e.clientWidth)"
        assert browser.execute_script(wide)


@pytest.mark.parametrize("verdict", ["nothing missing", "unknown"])
def test_every_verdict_is_drawn(browser, reports, verdict):
    errors, _ = load(browser, reports[verdict], 390, "light")
    assert not errors
    assert not browser.execute_script(TOO_WIDE)
    assert verdict in browser.execute_script(
        "return document.querySelector('.badge').textContent.toLowerCase()"
    )


def test_the_first_screen_holds_verdict_errors_and_what_to_do(browser, reports):
    load(browser, reports["named"], 1280, "light")
    for part in (".first ol", ".first img"):
        bottom = f"return document.querySelector('{part}').getBoundingClientRect().bottom"
        assert browser.execute_script(bottom) < VIEWPORTS[1280]


def test_print_cuts_nothing_at_the_edge_of_the_paper(browser, reports):
    """Hashes of files are longer than a line; paper does not scroll."""
    load(browser, reports["named"], 1280, "light")
    digest = "<code>" + "0123456789abcdef" * 8 + "</code>"
    files = f"<table class=files><tr><td><code>rig.csv</code></td><td>{digest}</td></tr></table>"
    browser.execute_script(f"document.querySelector('.scroll').innerHTML = '{files}'")
    metrics = {"width": 718, "height": 1000, "deviceScaleFactor": 1, "mobile": False}  # A4
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "print"})
    cut = "[...document.querySelectorAll('.scroll')].filter((e) => e.scrollWidth > e.clientWidth)"
    assert browser.execute_script(f"return {cut}.map((e) => e.outerHTML.slice(0, 200))") == []
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": ""})
