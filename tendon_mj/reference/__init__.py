"""Independent references for the friction model: lumped elements and the continuum.

They share no code with `tendon_mj.theory` and `tendon_mj.sheath`, and with each other the argument
checks only. Equations: docs/theory.md, sections 2 and 5.
"""

from tendon_mj.reference.chains import quasi_static as quasi_static
from tendon_mj.reference.chains import uniform_chain as uniform_chain
from tendon_mj.reference.continuum import Continuum as Continuum
from tendon_mj.reference.continuum import ContinuumRun as ContinuumRun
from tendon_mj.reference.continuum import continuum as continuum
from tendon_mj.reference.continuum import simulate_continuum as simulate_continuum
from tendon_mj.reference.effect_run import EffectRun as EffectRun
from tendon_mj.reference.effect_run import simulate_effects as simulate_effects
from tendon_mj.reference.effects import Carriage as Carriage
from tendon_mj.reference.effects import Effects as Effects
from tendon_mj.reference.elements import ElementChain as ElementChain
from tendon_mj.reference.energy import EnergyBalance as EnergyBalance
from tendon_mj.reference.run import ChainRun as ChainRun
from tendon_mj.reference.run import ChainState as ChainState
from tendon_mj.reference.run import simulate_chain as simulate_chain
