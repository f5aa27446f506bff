"""Sentences that say what to record next, so that effects which tie can be told apart."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from tendon_mj.lab.diagnosis import DISCRIMINATING_EXPERIMENTS, Effect


def advise(group: Sequence[str], catalogue: Mapping[str, Effect]) -> list[str]:
    """Sentences that say which experiment tells the effects of a group apart.

    Args:
        group: identifiers of the catalogue, two or more.
        catalogue: identifier → effect.

    Returns:
        One sentence for every pair that is known to tie; for effects in none of these, what
        brings each of them out.
    """
    said: list[str] = []
    covered: set[str] = set()
    for k, one in enumerate(group):
        for other in group[k + 1 :]:
            sentence = DISCRIMINATING_EXPERIMENTS.get(frozenset({one, other}))
            if sentence:
                covered |= {one, other}
                said += [sentence] if sentence not in said else []
    said += [
        f"For {name.replace('_', ' ')}, record {catalogue[name].next_experiment}."
        for name in group
        if name not in covered and catalogue[name].next_experiment
    ]
    return said
