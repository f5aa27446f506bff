"""Figures of a diagnosis."""

from __future__ import annotations

from collections.abc import Mapping

from matplotlib.figure import Figure

from tendon_mj.lab.diagnosis import BeforeAfter, Diagnosis
from tendon_mj.show.figures.before_after import before_after_figure
from tendon_mj.show.figures.error_bars import error_bars_figure
from tendon_mj.show.figures.misfit_map import misfit_figure, proof_figure


def diagnosis_figures(
    diagnosis: Diagnosis,
    shown: BeforeAfter,
    sysid: Mapping[str, float] | None = None,
) -> dict[str, Figure]:
    """Figures of a diagnosis by name.

    Args:
        diagnosis: to draw.
        shown: a recording, and its simulations before and after.
        sysid: column → held-out rms error of `mujoco.sysid` alone [the column's unit].

    Returns:
        "misfit" where there is one, "proof" where something was named, "gap", and
        "before_after".
    """
    changed = diagnosis.changed
    measured, before, after = shown
    figures = {}
    if diagnosis.verdict != "nothing missing":
        remaining = diagnosis.remaining if changed else None
        figures["misfit"] = misfit_figure(diagnosis.located, remaining)
    figures["gap"] = error_bars_figure(
        diagnosis.train, diagnosis.held_out, sysid, changed=changed, floors=diagnosis.bars
    )
    if changed:
        figures["proof"] = proof_figure(*diagnosis.proof, diagnosis.bars)
    figures["before_after"] = before_after_figure(measured, before, after if changed else None)
    return figures
