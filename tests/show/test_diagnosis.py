"""Pictures and page of a diagnosis show what it says, and nothing that a file says is believed."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest
from plotly.graph_objects import Figure

from tendon_mj.errors import RecordingError
from tendon_mj.lab.diagnosis import (
    CATALOGUE,
    DISCRIMINATING_EXPERIMENTS,
    BeforeAfter,
    Bin,
    Correlations,
    Diagnosis,
    ErrorReduction,
    Finding,
    Located,
    Provenance,
    Ranked,
    SysidResult,
    Value,
)
from tendon_mj.lab.recordings import Measured, Recording
from tendon_mj.lab.replay import Simulates
from tendon_mj.show import (
    before_after_figure,
    diagnosis_figures,
    new_figure,
    report_page,
    write_report,
)
from tendon_mj.show.report.advice import advise
from tendon_mj.show.report.charts.chart import text, thin
from tendon_mj.show.report.charts.curves import over_drive, over_time
from tendon_mj.show.report.charts.matrix import correlation_chart
from tendon_mj.show.report.first_screen import MEANING, headline, what_to_do
from tendon_mj.show.report.tables import short
from tendon_mj.show.report.write import as_png

COLUMN = "output_tension_N"


def recorded(name="slow", source="a test", offset=0.0):
    time = np.linspace(0.0, 4.0, 400)
    x = 1e-3 * np.sin(2.0 * np.pi * time)
    return Recording(
        name=name,
        model="bench",
        source=source,
        time=time,
        columns={"input_displacement_m": x, COLUMN: 20.0 + 5e3 * x + offset},
        drive={"input_displacement_m": "reel"},
        measured={COLUMN: Measured("output_tension", 0.1)},
    )


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
        held_out=gap,
        located=located(10.0),
        remaining=located(1.02),
        proof=(located(9.0), located(1.05)),
        sessions={},
        reproducibility={},
        before={"sheath.friction": 0.18},
        model={"sheath.friction": 0.18},
        seconds=1.0,
        catalogue=CATALOGUE,
        simulator=Still(),
        recordings=(train or recorded(),),
        held_out_recordings=(recorded("other"),),
    )


class Still(Simulates):
    """Simulator of which nothing is asked."""

    def __init__(self):
        self.parameters = {}

    def __call__(self, parameter_sets):
        return []


SYSID = SysidResult({"sheath.friction": (0.2, 0.199, 0.201)}, 9.0, 9.75, {COLUMN: 0.975}, 2.0, "")


DRAWN = [BeforeAfter(recorded("drawn"), recorded(offset=1.0), recorded(offset=0.1))]


def page(found, simulated=DRAWN, **more):
    picture = {"before_after": as_png(new_figure(1.0, 1.0))}
    return report_page(found, simulated, picture, **more)


def words(html):
    """Visible text of a page, with single spaces."""
    html = re.sub(r"<(script|style).*?</\1>", " ", html, flags=re.S)
    return " ".join(re.sub(r"<[^>]*>", " ", html).split())


@pytest.mark.parametrize("verdict", ["named", "parameter", "nothing missing", "unknown"])
def test_a_page_says_its_verdict_and_needs_nothing_else(verdict):
    html = page(diagnosis(verdict))
    assert f"The sentence of {verdict}." in words(html)
    assert 'src="data:image/png;base64,' in html
    assert not re.search(r"(?:src|href)=\"(?!data:)", html)
    assert "default-src 'none'" in html  # what a browser holds it to


@pytest.mark.parametrize(
    ("verdict", "more", "said"),
    [
        ("named", {}, "The model lacks a sensor with an offset (output_tension)."),
        ("parameter", {}, "Coefficient of friction"),
        ("nothing missing", {}, "Nothing is missing from the model."),
        ("unknown", {"closest": ("creep",)}, "Nothing in the catalogue explains the error."),
    ],
)
def test_the_first_screen_says_what_is_wrong_and_what_to_do(verdict, more, said):
    found = diagnosis(verdict, **more)
    html = page(found, model="model.xml")
    heading = words(re.search(r"<h1>.*?</h1>", html, re.S).group())
    first = words(html[html.index('class="first"') : html.index("</section>")])
    assert heading.lower().startswith(said.lower())
    assert MEANING[verdict] in first
    assert "What to do now" in first
    assert 'href="model.xml"' in html
    assert ("not proven" in first) == (verdict == "unknown")
    assert "output tension 1 " in first  # N, before


def test_a_finding_is_stated_with_its_value():
    found = diagnosis()
    stated = replace(found.findings[0], statement="dry friction of joint pip, 12 mN m")
    assert headline(replace(found, findings=(stated,))) == (
        "The model lacks dry friction of joint pip, 12 mN m."
    )
    wrong = replace(
        stated, kind="parameter", statement="the mass of body tip is too low: 12, not 9 g"
    )
    both = replace(found, verdict="partly", findings=(stated, wrong))
    assert headline(both) == (
        "In part, the model lacks dry friction of joint pip, 12 mN m; the mass of body tip is too"
        " low: 12, not 9 g."
    )
    somewhere = replace(stated, elsewhere=("dip",))
    assert "(output_tension or dip)" in headline(replace(found, findings=(somewhere,)))


def test_a_part_that_is_explained_is_no_whole_answer():
    said = what_to_do(replace(diagnosis(), verdict="partly"))
    assert "with care" in said[0]
    assert "Record more" in said[1]


def test_warnings_stand_on_the_first_screen():
    html = page(replace(diagnosis(), warnings=("The model's timestep is too long: 1.",)))
    first = words(html[html.index('class="first"') : html.index("</section>")])
    assert "The model&#39;s timestep is too long: 1." in first


def test_a_page_tells_where_it_comes_from():
    digest, date = "f" * 64, "2026-01-02T03:04:05"
    origin = Provenance(date, {"tendon-mj": "0.1"}, "tendon-mj diagnose <a>", {"a.csv": digest})
    said = words(page(diagnosis(), provenance=origin))
    for part in (date, "tendon-mj diagnose &lt;a&gt;", f"a.csv {digest}"):
        assert part in said


def test_values_are_in_units_that_engineers_read():
    value = Value(0.012, 0.011, 0.013, "N m", 0.0)
    said = words(page(replace(diagnosis(), parameters={"pip.frictionloss": value})))
    assert "pip.frictionloss 12 11 … 13 mN m 0" in said


def test_charts_are_what_plotly_takes():
    html = page(diagnosis(), sysid=SYSID)
    charts = json.loads(re.search(r'id="charts">(.*?)</script>', html, re.S).group(1))
    assert {"first", "errors", "signals", "misfit", "proof", "whiteness"} <= charts.keys()
    for chart in [chart for place in charts.values() for chart in place]:
        assert Figure(chart).data
    matrix = correlation_chart(Correlations(("a.b", "c.d"), ((1.0, 0.95), (0.95, 1.0))))
    assert Figure(matrix).data


def test_a_chart_shows_what_it_was_given():
    chart = over_time(DRAWN[0], COLUMN, changed=True)
    measured, before, residual, _, left = chart["data"]
    np.testing.assert_allclose(np.subtract(before["y"], measured["y"]), 1.0, atol=1e-3)
    np.testing.assert_allclose(residual["y"], 1.0, atol=1e-4)
    np.testing.assert_allclose(left["y"], 0.1, atol=1e-4)
    assert chart["layout"]["yaxis"]["title"]["text"] == "output tension [N]"
    assert chart["layout"]["shapes"][0]["y1"] == pytest.approx(0.2)  # twice the noise
    loop = over_drive(DRAWN[0], COLUMN, changed=True)
    assert loop["layout"]["xaxis"]["title"]["text"] == "input displacement [mm]"
    assert max(loop["data"][0]["x"]) == pytest.approx(1.0, abs=0.01)


def test_a_curve_is_thinned_without_losing_a_peak():
    values = np.sin(np.linspace(0.0, 50.0, 10_001))
    values[777] = 9.0
    kept = thin(values, 200)
    assert kept.size <= 202
    assert (np.diff(kept) > 0).all()
    assert {0, 777, 10_000} <= set(kept.tolist())
    np.testing.assert_array_equal(thin(values[:50], 200), np.arange(50))


def test_many_signals_stay_within_five_megabytes(tmp_path):
    names = [f"tension_{k}_N" for k in range(8)]
    random = np.random.default_rng(1)

    def many(offset=0.0):
        one = recorded()
        time = np.linspace(0.0, 60.0, 6_000)
        columns = {n: 20.0 + offset + random.normal(0.0, 1.0, time.size) for n in names}
        place = {"input_displacement_m": np.sin(time)}
        measured = {n: Measured("output_tension", 0.1) for n in names}
        return replace(one, time=time, columns=place | columns, measured=measured)

    errors = ErrorReduction(10.0, 1.0, 1.0, dict.fromkeys(names, (1.0, 0.1, 0.1)))
    found = replace(diagnosis(), held_out=errors, train=errors)
    written = write_report(found, [BeforeAfter(many(), many(1.0), many())], tmp_path)
    assert written[-1].stat().st_size < 5e6


def test_a_page_says_what_was_missing_and_how_sure():
    said = words(page(diagnosis()))
    effect = CATALOGUE["sensor_bias"]
    for part in (effect.name, effect.equation, effect.signature, effect.source):
        assert part in said
    assert "output_tension.offset 1 0.98 … 1.02 N 0" in said
    assert "97 % that it is this one" in said


def test_a_page_shows_the_fit_of_parameters_alone_beside_it():
    said = words(page(diagnosis(), sysid=SYSID))
    assert "leaves an error of 9.75 times the noise on held-out data" in said
    assert "this diagnosis leaves 1.02" in said
    assert "was left out" in words(page(diagnosis()))


def test_where_nothing_was_added_no_after_is_claimed():
    html = page(diagnosis("unknown"), sysid=SYSID)
    assert "this diagnosis leaves 10.00" in words(html)
    assert '<th class="n">after</th>' not in html


def test_what_is_closest_is_shown_and_called_not_proven():
    html = page(diagnosis("unknown", closest=("creep",)), sysid=SYSID)
    assert "this diagnosis leaves 1.02" in words(html)
    assert "Fitted parameters, not proven" in words(html)
    assert CATALOGUE["creep"].next_experiment in words(html)


def test_ties_come_with_the_experiment_that_settles_them():
    said = words(page(diagnosis(rivals=("sensor_gain",))))
    assert "sensor_bias or sensor_gain : these data can't tell" in said
    assert DISCRIMINATING_EXPERIMENTS[frozenset({"sensor_bias", "sensor_gain"})] in said


def test_text_from_files_is_text():
    bad = "<script>alert('&')</script>"
    named = replace(diagnosis(train=recorded(name="<b>slow", source=bad)), warnings=(bad,))
    shown = [BeforeAfter(recorded("<b>drawn"), recorded(offset=1.0), recorded())]
    html = page(named, shown, no_sysid=bad)
    assert "<script>alert" not in html
    assert html.count("&lt;script&gt;alert") == 3
    assert "<b>slow" not in html
    assert "<b>drawn" not in html
    assert text("<b>tip & <a href='x'>") == "&lt;b&gt;tip &amp; &lt;a href='x'&gt;"


def test_every_effect_has_an_experiment_and_every_pair_is_of_the_catalogue():
    assert all(effect.next_experiment for effect in CATALOGUE.values())
    for pair in DISCRIMINATING_EXPERIMENTS:
        assert len(pair) == 2
        assert pair <= CATALOGUE.keys()


def test_advice_speaks_of_every_effect_of_a_group():
    delay, lag = "sensor_delay", "sensor_lag"
    both = [DISCRIMINATING_EXPERIMENTS[frozenset({delay, lag})]]
    assert advise([delay, lag], CATALOGUE) == advise([lag, delay], CATALOGUE) == both
    said = advise([delay, lag, "creep"], CATALOGUE)
    assert len(said) == 2
    assert CATALOGUE["creep"].next_experiment in said[1]
    silent = {"creep": replace(CATALOGUE["creep"], next_experiment="")}
    assert advise(["creep"], silent) == []


def test_a_page_speaks_of_effects_of_ones_own():
    own = replace(
        CATALOGUE["sensor_bias"],
        signature="a trace of ours",
        source="our bench",
        next_experiment="our own motion",
    )
    found = replace(diagnosis(rivals=("creep",)), catalogue={**CATALOGUE, "sensor_bias": own})
    for part in ("a trace of ours", "our bench", "For sensor bias, record our own motion."):
        assert part in words(page(found))


def test_a_report_is_a_page_and_the_pictures_in_it(tmp_path):
    other = BeforeAfter(recorded("first"), recorded(), recorded())
    written = write_report(diagnosis(), [*DRAWN, other], tmp_path / "new")
    names = ["misfit.png", "gap.png", "proof.png", "before_after.png", "report.html"]
    assert [path.name for path in written] == names
    html = written[-1].read_text("utf-8")
    assert "Recording drawn: output tension" in html  # where the error is largest
    assert html.count('src="data:image/png;base64,') == 4
    assert "href=" not in html.replace('href="data:,"', "")  # no model lies there
    (tmp_path / "new" / "model.xml").write_text("<mujoco/>")
    again = write_report(diagnosis(), DRAWN, tmp_path / "new")[-1].read_text("utf-8")
    assert '<a href="model.xml">model.xml</a>' in again


def test_figures_name_units_and_draw_what_they_were_given():
    found = diagnosis()
    shown = BeforeAfter(recorded(), recorded(offset=1.0), recorded(offset=0.1))
    figures = diagnosis_figures(found, shown, {COLUMN: 0.975})
    assert set(figures) == {"misfit", "gap", "proof", "before_after"}
    loop, _, left, _ = figures["before_after"].axes
    assert loop.get_ylabel() == "output tension [N]"
    assert left.get_xlabel() == "input displacement [mm]"
    np.testing.assert_allclose(left.lines[0].get_ydata(), 1.0)
    np.testing.assert_allclose(left.lines[1].get_ydata(), 0.1)
    widths = sorted(bar.get_width() for bar in figures["gap"].axes[1].patches)
    np.testing.assert_allclose(widths, [1.02, 9.75, 10.0])


def test_the_map_shows_shares_of_what_there_was_before():
    found = diagnosis()
    shown = BeforeAfter(recorded(), recorded(), recorded())
    direction = diagnosis_figures(found, shown)["misfit"].axes[0]
    labels = [text.get_text() for text in direction.get_yticklabels()]
    bars = [[bar.get_width() for bar in bars] for bars in direction.containers]
    assert labels == ["pulling", "loosening"]
    np.testing.assert_allclose(bars[0], [50.0, 50.0])
    np.testing.assert_allclose(bars[1], [90.0, 10.0], rtol=1e-6)
    assert sum(bars[2]) == pytest.approx(100.0 * (1.02**2 - 1.0) / 99.0)


def test_the_proof_shows_the_error_of_every_regime_in_noise():
    shown = BeforeAfter(recorded(), recorded(), recorded())
    direction = diagnosis_figures(diagnosis(), shown)["proof"].axes[0]
    before, after = ([bar.get_width() for bar in bars] for bars in direction.containers)
    np.testing.assert_allclose(before, [p.rms for p in located(9.0).bins[:2]])
    np.testing.assert_allclose(after, [p.rms for p in located(1.05).bins[:2]])


def test_where_nothing_is_missing_there_is_no_map():
    shown = BeforeAfter(recorded(), recorded(), recorded())
    assert "misfit" not in diagnosis_figures(diagnosis("nothing missing"), shown)


def test_nothing_measured_is_refused():
    bare = replace(recorded(), measured={})
    with pytest.raises(RecordingError, match="nothing in"):
        before_after_figure(bare, bare)


@pytest.mark.parametrize(
    ("value", "said"),
    [(0.18, "0.18"), (20000.0, "20\u202f000"), (float("inf"), "–"), (1.23456, "1.235")],
)
def test_numbers_are_short(value, said):
    assert short(value) == said


def test_a_source_is_shown_as_it_is_written(tmp_path):
    odd = replace(recorded(), source=r"rig $\foo$ of $5")
    before_after_figure(odd, odd).savefig(tmp_path / "odd.png")
