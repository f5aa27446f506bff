"""Derivatives of residuals by differences, in no more simulations than it takes.

A term of one recording changes nothing in others. Terms that no recording has in common are moved
together, in one simulation; each gets the rows of its own recordings, which are the same to the bit
as if it had been moved alone.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from tendon_mj.lab.diagnosis.data.problem import Problem
from tendon_mj.lab.diagnosis.effects.effect import Term
from tendon_mj.lab.replay import recording_of
from tendon_mj.typing import FloatArray


def differences(
    problem: Problem,
    terms: Sequence[Term],
    parameters: Callable[[FloatArray], dict[str, float]],
    point: FloatArray,
    step: FloatArray,
    residual: FloatArray,
) -> FloatArray:
    """(m, p) derivatives of the residuals by scaled terms; infinite where a simulation failed.

    Args:
        problem: data.
        terms: (p,) terms.
        parameters: scaled terms (p,) → parameters.
        point, step: (p,) where, and by how much each is moved.
        residual: (m,) at the point.
    """
    acting = [recordings_of(term, problem) for term in terms]
    groups = _disjoint(acting)
    numbers = np.arange(point.size)

    def moved(members: list[int]) -> dict[str, float]:
        return parameters(point + np.where(np.isin(numbers, members), step, 0.0))

    changes = problem.residuals([moved(members) for members in groups]) - residual
    matrix = np.zeros((residual.size, point.size))
    for members, change in zip(groups, changes, strict=True):
        for k in members:
            own = change
            if len(members) > 1 and not np.isfinite(change).all():  # maybe by another's fault
                own = problem.residuals([moved([k])])[0] - residual
            elif len(members) > 1:
                own = np.where(np.isin(problem.recording_of, list(acting[k])), change, 0.0)
            matrix[:, k] = own / step[k]
    return matrix


def recordings_of(term: Term, problem: Problem) -> frozenset[int]:
    """Numbers of the recordings that a term may change."""
    names = {recording_of(target) for target in term.targets}
    return frozenset(
        k for k, one in enumerate(problem.recordings) if "" in names or one.name in names
    )


def _disjoint(recordings: Sequence[frozenset[int]]) -> list[list[int]]:
    """Groups of terms that no recording has in common; each term is in one."""
    groups: list[tuple[set[int], list[int]]] = []
    for k, own in enumerate(recordings):
        for taken, members in groups:
            if not taken & own:
                taken |= own
                members.append(k)
                break
        else:
            groups.append((set(own), [k]))
    return [members for _, members in groups]
