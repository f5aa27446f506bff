"""Report of a diagnosis: one HTML page with its tables and pictures, and no other files."""

from __future__ import annotations

import base64
import io
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup, escape
from matplotlib.figure import Figure

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
from tendon_mj.lab.replay import column_name, estimated_percent, percent, quantity
from tendon_mj.show.figures.style import DPI
from tendon_mj.show.report.pictures import (
    correlation_figure,
    diagnosis_figures,
    signal_figure,
    whiteness_figure,
)
from tendon_mj.show.report.text import (
    advise,
    error_rows,
    headline,
    meaning,
    most_telling,
    value_rows,
    what_to_do,
    written,
)
from tendon_mj.whole_file import whole_file

MODEL = "model.xml"
LEFT_OUT = "The comparison with mujoco.sysid was left out."
_HELD_BACK = {False: "its last quarter", True: "left out in turn"}


def page_templates() -> Environment:
    """The templates of the pages, which extend ``base.html``."""
    return Environment(
        loader=PackageLoader("tendon_mj.show"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )


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

    ``pictures`` are PNGs of `diagnosis_figures` by name; ``model`` is the file of the final model
    next to the page, empty where there is none.
    """
    environment = page_templates()
    environment.filters |= {
        "short": partial(written, digits=4),
        "percent": percent,
        "estimated_percent": estimated_percent,
        "signal": column_name,
        "file_name": lambda path: Path(path).name,
        "value_rows": value_rows,
        "quantity": quantity,
        "linked": partial(_with_links, file=model),
    }
    row, column = most_telling(simulated)
    rival = sysid.signals if sysid else None
    held_out = any(row.measured.name == r.name for r in _held_out_only(diagnosis))
    white, correlations = residual_autocorrelations(row), parameter_correlations(diagnosis)
    details = {
        "first": signal_figure(row, column, changed=diagnosis.changed),
        "whiteness": whiteness_figure(white, changed=diagnosis.changed),
    }
    if correlations:
        details["correlations"] = correlation_figure(correlations)
    shown = {**pictures, **{name: as_png(figure) for name, figure in details.items()}}
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
        pictures={name: base64.b64encode(png).decode() for name, png in shown.items()},
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
        use = kept = f"selection and fit; {_HELD_BACK[diagnosis.leaves_one_out]} for the proof"
    return [
        *((r, use) for r in diagnosis.recordings),
        *((r, kept) for r in _held_out_only(diagnosis)),
    ]


def _with_links(sentence: str, file: str) -> Markup:
    """A sentence with links to a file where it names it."""
    escaped = escape(sentence)
    link = Markup('<a href="{0}">{0}</a>').format(file)
    return Markup(escaped.replace(file, link)) if file else escaped
