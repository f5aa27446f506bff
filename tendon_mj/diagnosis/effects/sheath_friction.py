"""Friction of the sheath (capstan)."""

from __future__ import annotations

from tendon_mj.diagnosis.effect import Effect, Rig
from tendon_mj.diagnosis.place import Binding, Bound, Knob, on_sheaths


def _where_there_is_none(binding: Binding) -> Binding:
    """Only on a model whose sheaths rub nowhere; a wrong coefficient is `friction`."""

    def bind(rig: Rig) -> Bound:
        rubs = [rig.values[f"{sheath}.friction"] for sheath in rig.elements("friction")]
        return [] if any(rubs) else binding(rig)

    return bind


EFFECT = Effect(
    identifier="sheath_friction",
    name="friction of the sheath (capstan)",
    equation="T_high = T_low e^{μφ}",
    looks_like="output lags input in a wide loop whose width grows with the tension",
    source="Kaneko, Wada, Maekawa & Tanie 1991, eq. (1)",
    candidates=_where_there_is_none(on_sheaths(Knob("friction", "-", 0.0, 1.0, 0.02))),
    though_known=True,  # a coefficient of 0 says that the model has no friction, not the rig
)
