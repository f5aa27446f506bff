"""Wrong numbers of the bench's model, too high or too low."""

from __future__ import annotations

import numpy as np

from experiments.hidden_effects.effects.draws import Draw, on_attribute

# Wrong parameters of the model, which the recording states neither as known nor as uncertain.
PARAMETERS: dict[str, Draw] = {
    "friction": on_attribute(
        "friction", "friction", "sheath.friction", lambda s: 0.15 * (1.0 + s), 0.8
    ),
    "axial_stiffness": on_attribute(
        "axial_stiffness", "axial_stiffness", "sheath.axial_stiffness", lambda s: 2e4 * (1 + s), 0.6
    ),
    "pretension": on_attribute(
        "pretension", "pretension", "sheath.pretension", lambda s: 20.0 * (1.0 + s), 0.6
    ),
    "bend_angle": on_attribute(
        "bend_angle", "bend", "sheath.extra_bend", lambda s: np.pi * (1.0 + s), 0.5, less=np.pi
    ),
    "moment_arm": on_attribute(
        "moment_arm", "reel_scale", "reel.command_scale", lambda s: 1.0 + s, 0.25
    ),
}
