"""Digest of a compiled model, by which processes know that theirs is the same."""

from __future__ import annotations

import hashlib

import mujoco
import numpy as np


def model_digest(model: mujoco.MjModel) -> str:
    """16 hexadecimal digits of a compiled model's content."""
    content = np.empty(mujoco.mj_sizeModel(model), np.uint8)
    mujoco.mj_saveModel(model, None, content)
    return hashlib.sha256(content.tobytes()).hexdigest()[:16]
