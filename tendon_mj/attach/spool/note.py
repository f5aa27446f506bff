"""Keeps what the motors of a spool were on their tendon.

It is kept as the custom text ``<tendon>.tendon_mj_spool``, which holds the numbers of `Drive` of
each motor in a row. Copies of a spec and MJCF files keep a text digit for digit, and `attach` gives
it the tendon's prefix or suffix.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import chain

import mujoco

from tendon_mj.attach.spool.motor import Drive

_MARK = ".tendon_mj_spool"


def keep_drives(spec: mujoco.MjSpec, tendon: str, drives: Sequence[Drive]) -> None:
    """Note what the motors of a tendon are set to."""
    note = _note(spec, tendon)
    if note is not None:  # one that was left behind
        spec.delete(note)
    spec.add_text(name=f"{tendon}{_MARK}", data=" ".join(map(repr, chain(*drives))))


def kept_drives(spec: mujoco.MjSpec, tendon: str) -> list[Drive]:
    """Read the note; nothing for a tendon on whose spool there is no note."""
    note = _note(spec, tendon)
    if note is None:
        return []
    numbers = list(map(float, note.data.split()))
    width = len(Drive._fields)
    return [Drive(*numbers[k : k + width]) for k in range(0, len(numbers), width)]


def forget_drives(spec: mujoco.MjSpec, tendon: str) -> None:
    """Delete the note."""
    note = _note(spec, tendon)
    if note is not None:
        spec.delete(note)


def _note(spec: mujoco.MjSpec, tendon: str) -> mujoco.MjsText | None:
    for text in spec.texts:
        if _MARK in text.name and text.name.replace(_MARK, "", 1) == tendon:
            return text
    return None
