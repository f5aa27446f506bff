"""Protocol of a simulator, by which one of one's own can stand in for the package's `Simulator`."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from tendon_mj.lab.replay.parameters import Parameter

Values = Mapping[str, float]
Series = dict[str, NDArray[np.float64]]


class Simulates(Protocol):
    """Simulator of recordings, with parameters by name.

    A class of one's own either has all these members, or is derived from this one, sets
    ``parameters`` and defines ``__call__``; the others then answer as for a simulator that knows
    neither joints nor steps.

    Attributes:
        parameters: every parameter that it knows, at the value that it has when a set does not
            name it.
        joints: joint → whether a driven column prescribes its motion, so that no effect can be on
            it. Joints are the elements of the parameters of kind "joint"; one that is not named
            here is free.
        steps: time steps of one simulation of all recordings; 0 where it makes no error of steps.
            With 0 its answers are taken as exact; else a diagnosis searches in longer steps, if
            these change little, and takes the error of the steps out by Richardson's
            extrapolation.
        sessions: whether it takes ``<parameter> @ <recording>``, a value for one recording alone;
            without, recordings that have such in [session] are refused.
    """

    parameters: Mapping[str, Parameter]
    joints: Mapping[str, bool] = MappingProxyType({})
    steps: int = 0
    sessions: bool = False

    @abstractmethod
    def __call__(self, parameter_sets: Sequence[Values]) -> list[list[Series]]:
        """For every set, for every recording: measured column → (n,) at the samples.

        A simulation that failed has NaN in its series.
        """

    def in_steps(self, factor: float) -> Simulates:
        """This simulator in steps ``factor`` > 0 times as long; itself where ``steps`` is 0.

        It may keep steps shorter than asked for, as where the sampling interval limits them; its
        ``steps`` then say so.
        """
        return self
