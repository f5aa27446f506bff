"""Candidates: the joint's model with one law of friction or another, and models without."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

from experiments.measured_joint.bouc_wen import fit_bouc_wen
from experiments.measured_joint.copied_curves import fit_continued_curves, fit_copied_curves
from experiments.measured_joint.direct_fit import fit_directly
from experiments.measured_joint.history_network import fit_history_network
from experiments.measured_joint.joint_model import CAPSTAN, CONSTANT, FRICTIONLOSS, Number
from experiments.measured_joint.prandtl_ishlinskii import fit_prandtl_ishlinskii
from experiments.measured_joint.prediction import Fit
from experiments.measured_joint.sysid_alone import fit_as_described, fit_told_of_friction

FITTED_DIRECTLY = "capstan friction, fitted directly"


@dataclass(frozen=True)
class Candidate:
    """A model to compare.

    Attributes:
        name: in tables.
        numbers: how many it fits; None if it keeps whole curves.
        fit: makes a prediction from recordings and a seed.
        random: whether the seed matters.
    """

    name: str
    numbers: int | None
    fit: Fit
    random: bool = False


def _direct(name: str, numbers: Sequence[Number]) -> Candidate:
    return Candidate(name, len(numbers), partial(fit_directly, tuple(numbers)), random=True)


CANDIDATES = (
    _direct(FITTED_DIRECTLY, CAPSTAN),
    _direct("constant friction of the sheath in its place", CONSTANT),
    _direct("MuJoCo's frictionloss of the hinge in its place", FRICTIONLOSS),
    Candidate("mujoco.sysid, no friction in the sheath", 7, fit_as_described),
    Candidate("mujoco.sysid, told of capstan friction", 8, fit_told_of_friction),
    Candidate("Prandtl–Ishlinskii", 90, fit_prandtl_ishlinskii),
    Candidate("Bouc–Wen", 36, fit_bouc_wen, random=True),
    Candidate("network on histories", 1095, fit_history_network, random=True),
    Candidate("nearest curves", None, fit_copied_curves),
    Candidate("nearest curves, their line continued", None, fit_continued_curves),
)
