"""Report of a diagnosis as files: its pictures, and one page that shows them."""

from __future__ import annotations

import io
from collections.abc import Sequence
from pathlib import Path

from matplotlib.figure import Figure

from tendon_mj.lab.diagnosis import BeforeAfter, Diagnosis, Provenance, SysidResult
from tendon_mj.show.figures.style import DPI
from tendon_mj.show.report.figures import diagnosis_figures
from tendon_mj.show.report.first_screen import most_telling
from tendon_mj.show.report.page import LEFT_OUT, report_page
from tendon_mj.whole_file import whole_file

MODEL = "model.xml"


def as_png(figure: Figure) -> bytes:
    """A figure as the bytes of a PNG."""
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=DPI)
    return buffer.getvalue()


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
        simulated: what its ``simulate`` returned; the recording with the largest error before is
            drawn.
        folder: made if it is not there.
        sysid: fit of the same recordings by `mujoco.sysid`, for comparison.
        no_sysid: sentence for the page where that was left out.
        provenance: command and files for the page, see `collect_provenance`.

    Returns:
        Paths of what was written, the page last.
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
    written = []
    for name, picture in pictures.items():
        written.append(folder / f"{name}.png")
        with whole_file(written[-1]) as made:
            made.write_bytes(picture)
    page = folder / "report.html"
    with whole_file(page) as made:
        made.write_text(text, encoding="utf-8")
    return [*written, page]
