"""Report of a diagnosis: one HTML page with its tables, charts and pictures, and no other files."""

from __future__ import annotations

import base64
import io
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path

from markupsafe import Markup, escape
from PIL import Image

from tendon_mj.lab.diagnosis import (
    BeforeAfter,
    Diagnosis,
    Provenance,
    SysidResult,
    collect_provenance,
    noise_sensitivity,
    parameter_correlations,
    residual_autocorrelations,
)
from tendon_mj.lab.replay import estimated_percent, percent, quantity
from tendon_mj.show.figures.labels import column_name
from tendon_mj.show.figures.style import BLACK, BLUE, GREY, PALE, SKY
from tendon_mj.show.page.templates import templates
from tendon_mj.show.report.advice import advise
from tendon_mj.show.report.charts import bars, curves
from tendon_mj.show.report.charts.chart import Chart
from tendon_mj.show.report.charts.matrix import correlation_chart
from tendon_mj.show.report.first_screen import headline, meaning, most_telling, what_to_do
from tendon_mj.show.report.library import packed_plotly
from tendon_mj.show.report.tables import error_rows, short, value_rows

_KEPT = {False: "its last quarter", True: "left out in turn"}
LEFT_OUT = "The comparison with mujoco.sysid was left out."
# colours of the charts that a dark page shows otherwise
_DARK = {BLUE: SKY, BLACK: "#FFFFFF", GREY: PALE, PALE: GREY}
_SHARE, _COLOURS = 0.7, 96  # of a picture's size, and of its colours, that print needs


def report_page(
    diagnosis: Diagnosis,
    simulated: Sequence[BeforeAfter],
    pictures: Mapping[str, bytes],
    *,
    sysid: SysidResult | None = None,
    no_sysid: str = LEFT_OUT,
    provenance: Provenance | None = None,
    model: str = "",
) -> str:
    """The page as HTML. Every text that comes from a file is escaped.

    Args:
        diagnosis: to report.
        simulated: what its ``simulate`` returned; one recording or more.
        pictures: name → PNG of the figure that `diagnosis_figures` calls so, for print.
        sysid: fit of the same data by `mujoco.sysid` alone.
        no_sysid: sentence in its place where there is none.
        provenance: default: versions and date alone.
        model: file of the final model beside the page, to link to; empty where there is none.
    """
    environment = templates(Path(__file__).parent / "template")
    environment.filters |= {
        "short": short,
        "percent": percent,
        "estimated_percent": estimated_percent,
        "signal": column_name,
        "file_name": lambda path: Path(path).name,
        "value_rows": value_rows,
        "quantity": quantity,
        "linked": partial(_linked, file=model),
    }
    train, held_out = diagnosis.recordings, diagnosis.held_out_recordings
    rest = _KEPT[diagnosis.leaves_one_out]
    kept = "proof" if held_out else f"selection and fit; {rest} for the proof"
    row, column = most_telling(simulated)
    only = [r for r in held_out if r.name not in {seen.name for seen in train}]
    role = ", held out" if row.measured.name in {r.name for r in only} else ""
    white = residual_autocorrelations(row)
    correlations = parameter_correlations(diagnosis)
    rival = sysid.signals if sysid else None
    return environment.get_template("report.html").render(
        d=diagnosis,
        changed=diagnosis.changed,
        meaning=meaning(diagnosis),
        headline=headline(diagnosis),
        to_do=what_to_do(diagnosis),
        errors=error_rows(diagnosis.held_out, rival, diagnosis.reproducibility),
        errors_in_training=error_rows(diagnosis.train),
        catalogue=diagnosis.catalogue,
        stills={name: _inline(picture) for name, picture in pictures.items()},
        charts=_charts(diagnosis, row, column, rival)
        | {"whiteness": [curves.whiteness(c, w, diagnosis.changed) for c, w in white.items()]}
        | ({"correlations": [correlation_chart(correlations)]} if correlations else {}),
        colours=bars.COLOURS,
        dark=_DARK,
        library=packed_plotly(),
        shown=row.measured.name,
        role=role,
        signal=column,
        white=white,
        correlations=correlations,
        sensitivity=noise_sensitivity(diagnosis),
        sysid=sysid,
        no_sysid=no_sysid,
        provenance=provenance or collect_provenance(),
        ties=[(group, advise(group, diagnosis.catalogue)) for group in diagnosis.indistinguishable],
        recordings=[(r, "selection and fit" if held_out else kept) for r in train]
        + [(r, kept) for r in only],
    )


def _charts(
    diagnosis: Diagnosis, row: BeforeAfter, column: str, sysid: Mapping[str, float] | None
) -> dict[str, list[Chart]]:
    """Place on the page → its charts."""
    changed = diagnosis.changed
    charts = {
        "first": [curves.over_time(row, column, changed=changed)],
        "errors": [bars.errors(diagnosis.held_out, sysid, changed=changed, floors=diagnosis.bars)],
        "signals": [
            chart
            for c in row.measured.measured
            for chart in (
                curves.over_drive(row, c, changed=changed),
                curves.over_time(row, c, changed=changed, height=320),
            )
        ],
    }
    if diagnosis.verdict != "nothing missing":
        remaining = diagnosis.remaining if changed else None
        charts["misfit"] = list(bars.misfit(diagnosis.located, remaining).values())
    if changed:
        charts["proof"] = list(bars.proof(*diagnosis.proof, diagnosis.bars).values())
    return charts


def _linked(sentence: str, file: str) -> Markup:
    """A sentence that links to a file where it names it."""
    link = Markup('<a href="{0}">{0}</a>').format(file)
    said = escape(sentence)
    return Markup(said.replace(file, link)) if file else said


def _inline(picture: bytes) -> str:
    """A PNG made smaller, in base64."""
    drawn, small = Image.open(io.BytesIO(picture)).convert("RGB"), io.BytesIO()
    drawn.thumbnail((round(_SHARE * drawn.width), drawn.height))
    drawn.quantize(_COLOURS).save(small, format="png", optimize=True)
    return base64.b64encode(small.getvalue()).decode("ascii")
