"""Report of a diagnosis: one HTML page with its tables and pictures, without other files."""

from __future__ import annotations

import base64
import io
import math
from collections.abc import Mapping
from pathlib import Path

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from matplotlib.figure import Figure

from tendon_mj.diagnosis import Diagnosis, SysidResult
from tendon_mj.replay.units import column_unit
from tendon_mj.view.figures.labels import column_name
from tendon_mj.view.figures.style import DPI
from tendon_mj.view.report.advice import advise

_KEPT = {False: "its last quarter", True: "left out in turn"}
LEFT_OUT = "The comparison with mujoco.sysid was left out."


def report_page(
    diagnosis: Diagnosis,
    figures: Mapping[str, Figure],
    *,
    shown: str = "",
    sysid: SysidResult | None = None,
    no_sysid: str = LEFT_OUT,
) -> str:
    """The page as HTML. Every text that comes from a file is escaped.

    Args:
        diagnosis: to report.
        figures: name → figure, as `diagnosis_figures` names them.
        shown: name of the recording that is drawn.
        sysid: fit of the same data by `mujoco.sysid` alone.
        no_sysid: sentence in its place where there is none.
    """
    environment = Environment(
        loader=FileSystemLoader(Path(__file__).parent),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= {
        "short": short,
        "percent": _percent,
        "signal": column_name,
        "unit": lambda column: column_unit(column) or "–",
    }
    train, held_out = diagnosis.recordings, diagnosis.held_out_recordings
    rest = _KEPT[diagnosis.leaves_one_out]
    kept = "proof" if held_out else f"selection and fit; {rest} for the proof"
    return environment.get_template("report.html").render(
        d=diagnosis,
        changed=diagnosis.changed,
        model=train[0].model,
        catalogue=diagnosis.catalogue,
        pictures={name: _inline(figure) for name, figure in figures.items()},
        shown=shown,
        sysid=sysid,
        no_sysid=no_sysid,
        ties=[(group, advise(group, diagnosis.catalogue)) for group in diagnosis.indistinguishable],
        advice=advise(diagnosis.closest, diagnosis.catalogue),
        recordings=[(r, "selection and fit" if held_out else kept) for r in train]
        + [(r, kept) for r in held_out],
    )


def short(value: float) -> str:
    """A number to four significant digits."""
    if not math.isfinite(value):
        return "–"
    if 1e4 <= abs(value) < 1e7:
        return f"{value:,.0f}".replace(",", "\u202f")
    return f"{value:.4g}"


def _percent(share: float) -> str:
    """A share in whole percents; 100 % only where it is exactly 1."""
    if not math.isfinite(share):
        return "–"
    return "more than 99 %" if 0.995 <= share < 1.0 else f"{100.0 * share:.0f} %"


def _inline(figure: Figure) -> str:
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=DPI)
    return base64.b64encode(buffer.getvalue()).decode("ascii")
