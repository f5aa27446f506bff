"""Independent references for the friction model: lumped elements and the continuum.

They share no code with `tendon_mj.theory` and `tendon_mj.sheath`, and with each other only how
arguments are read. Equations: docs/theory.md, sections 2 and 5.
"""

from experiments.references.chain_run import ChainRun as ChainRun
from experiments.references.chain_run import ChainState as ChainState
from experiments.references.chain_run import EnergyBalance as EnergyBalance
from experiments.references.chain_run import simulate_chain as simulate_chain
from experiments.references.continuum import Continuum as Continuum
from experiments.references.continuum import ContinuumRun as ContinuumRun
from experiments.references.continuum import continuum as continuum
from experiments.references.continuum import simulate_continuum as simulate_continuum
from experiments.references.effects import Carriage as Carriage
from experiments.references.effects import EffectRun as EffectRun
from experiments.references.effects import Effects as Effects
from experiments.references.effects import simulate_effects as simulate_effects
from experiments.references.elements import ElementChain as ElementChain
from experiments.references.elements import quasi_static as quasi_static
from experiments.references.elements import uniform_chain as uniform_chain
