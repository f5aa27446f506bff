"""Figures asked of the study."""

from __future__ import annotations

import math

FRICTION = (0.18, 0.25)  # μ [-]
BETWEEN = math.radians(2.3)  # angle error on each bend between the given ones, rms [rad]
BEYOND = math.radians(3.3)  # on each bend beyond them [rad]
EFFECT = "sheath_friction"  # to be named first
