"""Laboratory (extra `lab`).

`recordings` and `data_check` read and check data; `replay` simulates them; `diagnosis`,
`experiment_design` (of an `experiment`) and `fleet` draw conclusions; `sweep` varies parameters;
`finger` has trajectories and motions; `bench_comparison` compares with theory, and `step_cost` with
models without sheaths; `tasks` distributes the work. Modules that many of them use are `units`,
`noise`, `parameter_names` and `progress`; `motion`, `frames` and `friction_effect` are for views
and clips.
"""

from collections.abc import Callable
from typing import Any

renderers: dict[str, Callable[[Any], str]] = {}  # HTML of results, by the packages above
