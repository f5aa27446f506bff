"""Page and pictures of a diagnosis show its results, and escape every text of a file."""

import base64
import hashlib
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tendon_mj.errors import RecordingError
from tendon_mj.lab.diagnosis import (
    CATALOGUE,
    DISCRIMINATING_EXPERIMENTS,
    MEANING,
    Autocorrelation,
    BeforeAfter,
    Bin,
    Correlations,
    Diagnosis,
    ErrorReduction,
    Finding,
    Located,
    Provenance,
    SysidResult,
    Value,
)
from tendon_mj.lab.diagnosis.result import Alternative, Ranked
from tendon_mj.lab.diagnosis.verdict import Evidence
from tendon_mj.lab.replay import Simulates
from tendon_mj.show import write_report
from tendon_mj.show.figures.simulations import before_after_figure
from tendon_mj.show.report.page import report_page
from tendon_mj.show.report.pictures import correlation_figure, diagnosis_figures, whiteness_figure
from tendon_mj.show.report.text import headline, what_to_do
from tests.lab.recorded import recorded as recording_of

COLUMN = "output_tension_N"


def recorded(name="slow", source="a test", offset=0.0):
    time = np.linspace(0.0, 4.0, 400)
    x = 1e-3 * np.sin(2.0 * np.pi * time)
    measured = {COLUMN: ("output_tension", 0.1, 20.0 + 5e3 * x + offset)}
    drive = {"input_displacement_m": ("reel", x)}
    return recording_of(time, drive, measured, name=name, source=source)


def located(rms):
    excess = 1.0 if rms > 1.0 else 0.0
    return Located(
        bins=(
            Bin("direction", "pulling", 0.9 * excess, 0.5, np.sqrt(1.8 * (rms**2 - 1.0) + 1.0)),
            Bin("direction", "loosening", 0.1 * excess, 0.5, np.sqrt(0.2 * (rms**2 - 1.0) + 1.0)),
            Bin("signal", COLUMN, excess, 1.0, rms),
        ),
        sentence=f"The misfit is {rms:.1f} times the noise.",
        frequency=0.5,
    )


def diagnosis(verdict="named", rivals=(), closest=(), train=None):
    identifier = "sensor_bias" if verdict == "named" else "friction"
    effect = CATALOGUE[identifier]
    finding = Finding(
        identifier, effect.name, effect.equation, "output_tension", effect.kind, 0.97, tuple(rivals)
    )
    named = verdict in ("named", "parameter")
    gap = ErrorReduction(10.0, 1.02, 1.0, {COLUMN: (1.0, 0.102, 0.1)})
    value = Value(1.0, 0.98, 1.02, "N", 0.0)
    return Diagnosis(
        verdict=verdict,
        sentence=f"The sentence of {verdict}.",
        findings=(finding,) if named else (),
        closest=tuple(closest),
        excluded=(),
        ranking=(
            Ranked("sensor_bias", "output_tension", 0.97, 1.02),
            Ranked("sensor_gain", "output_tension", 0.61, None),
        ),
        calibrated={"sheath.friction": Value(0.18, 0.17, 0.19, "", 0.15)},
        parameters={"output_tension.offset": value} if named else {},
        train=gap,
        evidence=Evidence(held_out=gap, weighed=gap, extrapolated=gap, limit=0.2),
        located=located(10.0),
        remaining=located(1.02),
        proof=(located(9.0), located(1.05)),
        sessions={},
        before={"sheath.friction": 0.18},
        model={"sheath.friction": 0.18},
        seconds=1.0,
        catalogue=CATALOGUE,
        simulator=Still(),
        recordings=(train or recorded(),),
        held_out_recordings=(recorded("other"),),
    )


class Still(Simulates):
    """A simulator that is never called."""

    def __init__(self):
        self.parameters = {}

    def __call__(self, parameter_sets):
        return []


SYSID = SysidResult({"sheath.friction": (0.2, 0.199, 0.201)}, 9.0, 9.75, {COLUMN: 0.975}, 2.0, "")
DRAWN = [BeforeAfter(recorded("drawn"), recorded(offset=1.0), recorded(offset=0.1))]


def page(result, simulated=DRAWN, **more):
    return report_page(result, simulated, {}, **more)


def words(html):
    """Visible text of a page, with single spaces."""
    html = re.sub(r"<(script|style).*?</\1>", " ", html, flags=re.S)
    return " ".join(re.sub(r"<[^>]*>", " ", html).split())


def first_screen(html):
    return words(html[html.index('class="first"') : html.index("</section>")])


@pytest.mark.parametrize(
    ("verdict", "closest", "heading"),
    [
        ("named", (), "The rig has a sensor with an offset (output_tension)."),
        ("parameter", (), "Coefficient of friction"),
        ("nothing missing", (), "Nothing is missing from the model."),
        ("unknown", ("creep",), "Nothing was found that explains the error."),
    ],
)
def test_a_page_has_verdict_finding_and_next_steps_first_and_needs_no_other_file(
    verdict, closest, heading
):
    html = page(diagnosis(verdict, closest=closest), model="<mujoco/>")
    first = first_screen(html)
    assert words(re.search(r"<h1>.*?</h1>", html, re.S).group()).startswith(heading)
    assert MEANING[verdict] in first
    assert "What to do now" in first
    assert ("not proven" in first) == (verdict == "unknown")
    assert "output tension 1 " in first  # N, before
    assert f"The sentence of {verdict}." in words(html)
    assert html.count('src="data:image/png;base64,') == 2  # the signal, and its whiteness
    linked = set(re.findall(r"(?:src|href)=\"(?!data:)([^\"]*)", html))
    assert linked == {f"#{place}" for place in re.findall(r"<h2 id=\"([^\"]*)", html)}
    assert "default-src 'none'" in html  # the browser enforces it
    script = re.search(r"<script>(.*?)</script>", html, re.S)[1]  # the only one that may run
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
    assert f"script-src 'sha256-{digest}'" in html


def test_what_comes_closest_is_folded_and_marked_and_after_the_verdict():
    html = page(diagnosis("unknown", closest=("creep",)))
    folded = re.findall(
        r"<details class=\"closest\"><summary>(.*?)</summary>(.*?)</details>", html, re.S
    )
    assert [summary for summary, _ in folded] == 2 * ["What comes closest, not proven"]
    rest = html
    for summary, inside in folded:
        assert "creep" in inside
        rest = rest.replace(summary, "").replace(inside, "")
    first = rest[rest.index('class="first"') : rest.index("</section>")]
    assert html.index("Nothing was found that explains") < html.index("comes closest")
    assert "10.00 times the noise" in words(first)
    assert "1.02" not in words(first)  # the error with what comes closest
    assert "0.18" not in words(rest[: rest.index("Candidate set")])


def test_a_page_states_first_whether_what_remains_is_white():
    noise = np.random.default_rng(0).normal(0.0, 0.1, 400)
    time, x = recorded().time, recorded().columns[COLUMN]
    for error, white in ((noise, True), (np.sin(time), False)):
        after = replace(recorded(), columns=recorded().columns | {COLUMN: x + error})
        first = first_screen(page(diagnosis(), [BeforeAfter(recorded(), recorded(), after)]))
        assert ("looks like noise" in first) == white
        assert ("is correlated (output tension)" in first) != white


def test_numbers_that_cannot_be_told_are_on_the_first_screen() -> None:
    result = diagnosis()
    name = next(iter(result.calibrated))
    value = result.calibrated[name].value
    other = Alternative("backlash", "play of 0.4 mm", {name: 0.5 * value}, fitted=True)
    told = replace(result, verdict="undetermined", findings=(), alternatives=(other,))
    assert name in headline(told)
    (todo,) = what_to_do(told)
    assert "play of 0.4 mm" in todo
    assert "To decide, record" in todo


def test_a_page_has_warnings_first_values_in_engineers_units_and_its_provenance():
    digest, date = "f" * 64, "2026-01-02T03:04:05"
    origin = Provenance(date, {"tendon-mj": "0.1"}, "tendon-mj diagnose <a>", {"a.csv": digest})
    value = Value(0.012, 0.011, 0.013, "N m", 0.0)
    named = replace(diagnosis(), warnings=("It's long.",), parameters={"pip.frictionloss": value})
    html = page(named, provenance=origin)
    assert "It&#39;s long." in first_screen(html)
    values = "pip.frictionloss 12 11 … 13 mN m 0"
    for part in (values, date, "tendon-mj diagnose &lt;a&gt;", f"a.csv {digest}"):
        assert part in words(html)


def test_whiteness_and_correlations_are_drawn_as_they_are():
    lags, values = np.array([0.1, 0.2]), np.array([0.5, -0.2])
    before, after = Autocorrelation(lags, values, 0.1), Autocorrelation(lags, 0.1 * values, 0.1)
    axes, *_ = whiteness_figure({COLUMN: (before, after)}, changed=True).axes
    assert axes.get_xlabel() == "lag [ms]"
    np.testing.assert_allclose(axes.lines[0].get_xydata(), [[100.0, 0.5], [200.0, -0.2]])
    np.testing.assert_allclose(axes.lines[1].get_ydata(), [0.05, -0.02])
    (axes,) = correlation_figure(Correlations(("a.b", "c.d"), ((1.0, 0.95), (0.95, 1.0)))).axes
    assert [text.get_text() for text in axes.texts] == ["1.00", "0.95", "0.95", "1.00"]
    assert [label.get_text() for label in axes.get_yticklabels()] == ["a.b", "c.d"]


def test_a_page_has_the_missing_effect_its_confidence_and_the_fit_of_parameters_alone():
    effect, text = CATALOGUE["sensor_bias"], words(page(diagnosis(), sysid=SYSID))
    for part in (
        *(effect.name, effect.equation, effect.signature, effect.source),
        "output_tension.offset 1 0.98 … 1.02 N 0",
        "97 % that it is this one",
        "leaves an error of 9.75 times the noise on held-out data",
        "this diagnosis leaves 1.02",
    ):
        assert part in text
    assert "was left out" in words(page(diagnosis()))


def test_ties_come_with_the_experiment_that_settles_them():
    text = words(page(diagnosis(rivals=("sensor_gain",))))
    assert "sensor_bias or sensor_gain : these data can't tell" in text
    assert DISCRIMINATING_EXPERIMENTS[frozenset({"sensor_bias", "sensor_gain"})] in text


def test_text_from_files_is_text():
    bad = "<script>alert('&')</script>"
    named = replace(diagnosis(train=recorded(name="<b>slow", source=bad)), warnings=(bad,))
    shown = [BeforeAfter(recorded("<b>drawn"), recorded(offset=1.0), recorded())]
    html = page(named, shown, no_sysid=bad)
    assert "<script>alert" not in html
    assert html.count("&lt;script&gt;alert") == 3
    assert "<b>slow" not in html
    assert "<b>drawn" not in html


def test_every_effect_has_an_experiment_and_every_pair_is_of_the_catalogue():
    assert all(effect.next_experiment for effect in CATALOGUE.values())
    for pair in DISCRIMINATING_EXPERIMENTS:
        assert len(pair) == 2
        assert pair <= CATALOGUE.keys()


def test_a_report_is_a_page_and_the_pictures_in_it(tmp_path, monkeypatch):
    monkeypatch.setenv("MUJOCO_GL", "off")  # without OpenGL, only that of the rig is missing
    other = BeforeAfter(recorded("first"), recorded(), recorded())
    written = write_report(diagnosis(), [*DRAWN, other], tmp_path / "new")
    names = ["misfit.png", "gap.png", "proof.png", "before_after.png", "report.html"]
    assert [path.name for path in written] == names
    html = written[-1].read_text("utf-8")
    assert "Recording drawn: output tension" in html  # where the error is largest
    assert html.count('src="data:image/png;base64,') == 5  # one signal: as on the first screen
    assert "model" not in re.findall(r"href=\"#([^\"]*)", html)  # none lies there
    (tmp_path / "new" / "model.xml").write_text("<mujoco/><!-- Written with\n  a = 1 [N] -->")
    again = write_report(diagnosis(), DRAWN, tmp_path / "new")[-1].read_text("utf-8")
    assert '<a href="#model">model.xml</a>' in again
    (saved,) = re.findall(r'href="data:application/xml;base64,([^"]*)"', again)
    assert base64.b64decode(saved) == (tmp_path / "new" / "model.xml").read_bytes()
    assert "&lt;mujoco/&gt;" in again
    assert "<pre>Written with\na = 1 [N]</pre>" in again  # what was changed


def test_a_report_shows_the_rig_when_its_tension_is_highest(tmp_path, gl):
    *_, picture, report = write_report(diagnosis(), DRAWN, tmp_path)
    assert picture.name == "rig.png"
    assert picture.stat().st_size < 100e3
    assert base64.b64encode(picture.read_bytes()).decode() in report.read_text("utf-8")


def test_a_report_names_no_folder_of_its_author(monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    home, here = str(Path.home() / "secret" / "a.csv"), str(tmp_path / "b.toml")
    made = Provenance("2026-01-01", {"tendon-mj": "1"}, f"tendon-mj check {here}", {home: "0"})
    html = page(diagnosis(), provenance=made)
    assert "<code>tendon-mj check b.toml</code> <button" in html
    assert "<code>~/secret/a.csv</code>" in html
    assert str(tmp_path) not in html
    assert str(Path.home()) not in html


def test_fitted_parameters_are_a_table_with_units():
    result = diagnosis()
    table = result.to_dataframe()
    assert table.index.name == "parameter"
    assert list(table.index) == [*result.parameters, *result.calibrated]
    assert {"value", "low", "high", "unit", "before", "finding"} <= set(table.columns)
    for name, value in {**result.parameters, **result.calibrated}.items():
        row = table.loc[name]
        assert (row["value"], row["unit"]) == (value.value, value.unit)
        assert row["finding"] == (name in result.parameters)


def test_figures_name_units_and_draw_what_they_were_given():
    figures = diagnosis_figures(diagnosis(), DRAWN[0], {COLUMN: 0.975})
    assert set(figures) == {"misfit", "gap", "proof", "before_after"}
    loop, _, left, _ = figures["before_after"].axes
    assert loop.get_ylabel() == "output tension [N]"
    assert left.get_xlabel() == "input displacement [mm]"
    np.testing.assert_allclose(left.lines[0].get_ydata(), 1.0)
    np.testing.assert_allclose(left.lines[1].get_ydata(), 0.1)
    widths = sorted(bar.get_width() for bar in figures["gap"].axes[1].patches)
    np.testing.assert_allclose(widths, [1.02, 9.75, 10.0])


def test_the_map_has_shares_of_the_misfit_before_and_the_proof_errors_in_noise():
    figures = diagnosis_figures(diagnosis(), DRAWN[0])
    direction = figures["misfit"].axes[0]
    labels = [text.get_text() for text in direction.get_yticklabels()]
    bars = [[bar.get_width() for bar in bars] for bars in direction.containers]
    assert labels == ["pulling", "loosening"]
    np.testing.assert_allclose(bars[0], [50.0, 50.0])
    np.testing.assert_allclose(bars[1], [90.0, 10.0], rtol=1e-6)
    assert sum(bars[2]) == pytest.approx(100.0 * (1.02**2 - 1.0) / 99.0)
    direction = figures["proof"].axes[0]
    before, after = ([bar.get_width() for bar in bars] for bars in direction.containers)
    np.testing.assert_allclose(before, [p.rms for p in located(9.0).bins[:2]])
    np.testing.assert_allclose(after, [p.rms for p in located(1.05).bins[:2]])

    assert "misfit" not in diagnosis_figures(diagnosis("nothing missing"), DRAWN[0])


def test_a_recording_without_measurement_is_refused():
    bare = replace(recorded(), measured={})
    with pytest.raises(RecordingError):
        before_after_figure(bare, bare)


def test_a_source_is_shown_as_it_is_written(tmp_path):
    odd = replace(recorded(), source=r"rig $\foo$ of $5")
    before_after_figure(odd, odd).savefig(tmp_path / "odd.png")
