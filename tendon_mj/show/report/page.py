"""Report of a diagnosis: one HTML page with its tables and pictures, and no other files."""

from __future__ import annotations

import base64
import hashlib
import inspect
import io
import os
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

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
from tendon_mj.lab.units import column_name, estimated_percent, percent, quantity
from tendon_mj.show.report.pictures import (
    correlation_figure,
    diagnosis_figures,
    signal_figure,
    whiteness_figure,
)
from tendon_mj.show.report.rig import rig_figure
from tendon_mj.show.report.text import (
    advise,
    error_rows,
    headline,
    meaning,
    most_telling,
    remainder,
    value_rows,
    what_to_do,
    written,
)
from tendon_mj.show.style import DPI
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

    The page needs no other file; it holds ``model.xml`` if that is in the folder already. Where
    there is no OpenGL to draw with, it lacks the picture of the rig.

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
    rig = rig_figure(shown)
    if rig is not None:
        pictures["rig"] = as_png(rig)
    text = report_page(
        diagnosis,
        simulated,
        pictures,
        sysid=sysid,
        no_sysid=no_sysid,
        provenance=provenance,
        model=(folder / MODEL).read_text("utf-8") if (folder / MODEL).is_file() else "",
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

    ``pictures`` are PNGs of `diagnosis_figures` by name; ``model`` is the MJCF text of the final
    model, empty if there is none.
    """
    row, column = most_telling(simulated)
    correlations = parameter_correlations(diagnosis)
    first = _first(diagnosis, row, column, sysid.signals if sysid else None)
    details = {"whiteness": whiteness_figure(first["white"], changed=diagnosis.changed)}
    if correlations:
        details["correlations"] = correlation_figure(correlations)
    first["pictures"] |= {
        name: base64.b64encode(png).decode()
        for name, png in {**pictures, **{n: as_png(f) for n, f in details.items()}}.items()
    }
    ties = [(group, advise(group, diagnosis.catalogue)) for group in diagnosis.indistinguishable]
    return (
        _environment(linked=bool(model))
        .get_template("report.html")
        .render(
            first,
            errors_in_training=error_rows(diagnosis.train),
            catalogue=diagnosis.catalogue,
            correlations=correlations,
            sensitivity=noise_sensitivity(diagnosis),
            sysid=sysid,
            no_sysid=no_sysid,
            provenance=provenance or collect_provenance(),
            ties=ties,
            recordings=_uses(diagnosis),
            model=model,
            model_says=inspect.cleandoc(model.partition("<!--")[2].partition("-->")[0]).strip(),
            model_reads=_files_of(model),
            model_file=base64.b64encode(model.encode()).decode(),
        )
    )


def _files_of(model: str) -> list[str]:
    """Files that the MJCF text of a model reads, such as meshes."""
    elements = ElementTree.fromstring(model).iter() if model else ()
    return sorted({element.get("file", "") for element in elements} - {""})


def first_screen(diagnosis: Diagnosis) -> str:
    """First screen of the page as HTML without a style, for a notebook; simulates once more."""
    first = _first(diagnosis, *most_telling(diagnosis.simulate()))
    page = _environment().get_template("first.html").render(first)
    return page.replace("<img ", '<img style="max-width: 100%" ')


def _environment(*, linked: bool = False) -> Environment:
    environment = page_templates()
    script = environment.get_template("copy.js").render()
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
    environment.globals |= {"script": Markup(script), "script_digest": digest}
    environment.filters |= {
        "short": partial(written, digits=4),
        "percent": percent,
        "estimated_percent": estimated_percent,
        "signal": column_name,
        "file_name": lambda path: Path(path).name,
        "value_rows": value_rows,
        "quantity": quantity,
        "linked": _with_links if linked else escape,
        "local": _local,
    }
    return environment


def _first(
    diagnosis: Diagnosis, row: BeforeAfter, column: str, rival: Mapping[str, float] | None = None
) -> dict[str, Any]:
    """Names of the template of the first screen: texts, and the signal that tells most."""
    white = residual_autocorrelations(row)
    held_out = any(row.measured.name == r.name for r in _held_out_only(diagnosis))
    picture = as_png(signal_figure(row, column, changed=bool(diagnosis.findings)))
    return {
        "d": diagnosis,
        "changed": diagnosis.changed,
        "meaning": meaning(diagnosis),
        "headline": headline(diagnosis),
        "to_do": what_to_do(diagnosis),
        "white": white,
        "remainder": remainder(white),
        "errors": error_rows(diagnosis.held_out, rival, diagnosis.reproducibility),
        "pictures": {"first": base64.b64encode(picture).decode()},
        "shown": row.measured.name,
        "role": ", held out" if held_out else "",
        "signal": column,
    }


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


def _with_links(sentence: str) -> Markup:
    """A sentence with links to the model in the page where it names it."""
    link = Markup('<a href="#model">{0}</a>').format(MODEL)
    return Markup(escape(sentence).replace(MODEL, link))


def _local(text: str) -> str:
    """A path or command from the current folder, or from ~, so that it names no user."""
    for folder, short in ((Path.cwd(), ""), (Path.home(), f"~{os.sep}")):
        if folder != Path(folder.anchor):
            text = text.replace(f"{folder}{os.sep}", short)
    return text
