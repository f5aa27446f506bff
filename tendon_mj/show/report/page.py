"""Report of a diagnosis: one HTML page with its tables, charts and pictures, and no other files."""

from __future__ import annotations

import base64
import gzip
import io
from collections.abc import Mapping, Sequence
from functools import cache, partial
from pathlib import Path

from markupsafe import Markup, escape
from matplotlib.figure import Figure
from PIL import Image
from plotly.offline import get_plotlyjs

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
from tendon_mj.lab.recordings import Recording
from tendon_mj.lab.replay import estimated_percent, percent, quantity
from tendon_mj.show.figures.style import BLACK, BLUE, DPI, GREY, PALE, SKY, column_name
from tendon_mj.show.page import page_templates
from tendon_mj.show.report.bars import LABEL_COLOURS
from tendon_mj.show.report.charts import (
    Chart,
    correlation_chart,
    errors_chart,
    misfit_charts,
    over_drive,
    over_time,
    proof_charts,
    whiteness_chart,
)
from tendon_mj.show.report.pictures import diagnosis_figures
from tendon_mj.show.report.text import (
    advise,
    error_rows,
    headline,
    meaning,
    most_telling,
    short,
    value_rows,
    what_to_do,
)
from tendon_mj.whole_file import whole_file

MODEL = "model.xml"
LEFT_OUT = "The comparison with mujoco.sysid was left out."
_KEPT = {False: "its last quarter", True: "left out in turn"}
# colours of the charts that a dark page shows otherwise
_DARK = {BLUE: SKY, BLACK: "#FFFFFF", GREY: PALE, PALE: GREY}
_SHARE, _PRINTED = 0.7, 96  # of a picture's size, and of its colours, that print needs


def write_report(
    diagnosis: Diagnosis,
    simulated: Sequence[BeforeAfter],
    folder: str | Path,
    *,
    sysid: SysidResult | None = None,
    no_sysid: str = LEFT_OUT,
    provenance: Provenance | None = None,
) -> list[Path]:
    """Write ``report.html`` and its pictures, each as a PNG too.

    The page needs no other file. It links to ``model.xml`` where that lies in the folder already.

    Args:
        diagnosis: to report.
        simulated: result of its ``simulate``; the recording with the largest error before is
            drawn.
        folder: made if it is not there.
        sysid: fit of the same recordings by `mujoco.sysid`, for comparison.
        no_sysid: sentence for the page where that was left out.
        provenance: command and files for the page, see `collect_provenance`.

    Returns:
        Paths of the files, the page last.
    """
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    shown, _ = most_telling(simulated)
    figures = diagnosis_figures(diagnosis, shown, sysid.signals if sysid else None)
    pictures = {name: as_png(figure) for name, figure in figures.items()}
    text = report_page(
        diagnosis,
        simulated,
        pictures,
        sysid=sysid,
        no_sysid=no_sysid,
        provenance=provenance,
        model=MODEL if (folder / MODEL).is_file() else "",
    )
    contents = {f"{name}.png": picture for name, picture in pictures.items()}
    contents["report.html"] = text.encode()
    for name, content in contents.items():
        with whole_file(folder / name) as made:
            made.write_bytes(content)
    return [folder / name for name in contents]


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
    """The page as HTML, see `write_report`. Every text that comes from a file is escaped.

    ``pictures`` are PNGs of `diagnosis_figures` by name, for print; ``model`` is the file of the
    final model next to the page, empty where there is none.
    """
    environment = page_templates()
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
    row, column = most_telling(simulated)
    rival = sysid.signals if sysid else None
    held_out = any(row.measured.name == r.name for r in _held_out_only(diagnosis))
    white, correlations = residual_autocorrelations(row), parameter_correlations(diagnosis)
    charts = _charts(diagnosis, row, column, rival)
    charts["whiteness"] = [whiteness_chart(c, w, diagnosis.changed) for c, w in white.items()]
    if correlations:
        charts["correlations"] = [correlation_chart(correlations)]
    ties = [(group, advise(group, diagnosis.catalogue)) for group in diagnosis.indistinguishable]
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
        charts=charts,
        colours=LABEL_COLOURS,
        dark=_DARK,
        library=_packed_plotly(),
        shown=row.measured.name,
        role=", held out" if held_out else "",
        signal=column,
        white=white,
        correlations=correlations,
        sensitivity=noise_sensitivity(diagnosis),
        sysid=sysid,
        no_sysid=no_sysid,
        provenance=provenance or collect_provenance(),
        ties=ties,
        recordings=_uses(diagnosis),
    )


def as_png(figure: Figure) -> bytes:
    """A figure as the bytes of a PNG."""
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=DPI)
    return buffer.getvalue()


def _held_out_only(diagnosis: Diagnosis) -> list[Recording]:
    """Recordings that no model was selected or fitted on."""
    trained = {recording.name for recording in diagnosis.recordings}
    return [r for r in diagnosis.held_out_recordings if r.name not in trained]


def _uses(diagnosis: Diagnosis) -> list[tuple[Recording, str]]:
    """Every recording with its use."""
    use, kept = "selection and fit", "proof"
    if not diagnosis.held_out_recordings:
        use = kept = f"selection and fit; {_KEPT[diagnosis.leaves_one_out]} for the proof"
    return [
        *((r, use) for r in diagnosis.recordings),
        *((r, kept) for r in _held_out_only(diagnosis)),
    ]


def _charts(
    diagnosis: Diagnosis, row: BeforeAfter, column: str, sysid: Mapping[str, float] | None
) -> dict[str, list[Chart]]:
    """Place on the page → its charts."""
    changed, held_out, bars = diagnosis.changed, diagnosis.held_out, diagnosis.bars
    charts = {
        "first": [over_time(row, column, changed=changed)],
        "errors": [errors_chart(held_out, sysid, changed=changed, floors=bars)],
        "signals": [
            chart
            for c in row.measured.measured
            for chart in (
                over_drive(row, c, changed=changed),
                over_time(row, c, changed=changed, height=320),
            )
        ],
    }
    if diagnosis.verdict != "nothing missing":
        charts["misfit"] = misfit_charts(
            diagnosis.located, diagnosis.remaining if changed else None
        )
    if changed:
        charts["proof"] = proof_charts(*diagnosis.proof, bars)
    return charts


@cache
def _packed_plotly() -> str:
    """plotly.js, compressed with gzip, in base64: 2 of its 4.8 MB; a browser unpacks it itself."""
    return base64.b64encode(gzip.compress(get_plotlyjs().encode(), 9, mtime=0)).decode("ascii")


def _linked(sentence: str, file: str) -> Markup:
    """A sentence with links to a file where it names it."""
    escaped = escape(sentence)
    link = Markup('<a href="{0}">{0}</a>').format(file)
    return Markup(escaped.replace(file, link)) if file else escaped


def _inline(picture: bytes) -> str:
    """A PNG made smaller, in base64."""
    drawn, small = Image.open(io.BytesIO(picture)).convert("RGB"), io.BytesIO()
    drawn.thumbnail((round(_SHARE * drawn.width), drawn.height))
    drawn.quantize(_PRINTED).save(small, format="png", optimize=True)
    return base64.b64encode(small.getvalue()).decode("ascii")
