"""Figures asked of the study, and the published ones beside which it stands."""

from __future__ import annotations

import math

TORQUE_ASKED = 6e-3  # error on loads and wrist poses left out [N m]
RATE_ASKED = 0.06  # change of friction over a threefold rate [-]
# neural network on motor current and encoder, O'Neill, Stephens and Kowalewski, 2018
TORQUE_PUBLISHED = 4.42e-3  # [N m]
ANGLE_PUBLISHED = math.radians(0.37)  # [rad]
