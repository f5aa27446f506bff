"""Plugin of pytest: the package is imported without its plugins, which take minutes to compile.

Its modules below are found as ever, so that the tests of one that imports no engine run at once.
"""

import importlib.util
import sys
from pathlib import Path

_ROOT = Path(__file__).parents[2] / "tendon_mj"
_spec = importlib.util.spec_from_file_location(
    "tendon_mj", _ROOT / "__init__.py", submodule_search_locations=[str(_ROOT)]
)
assert _spec is not None
sys.modules["tendon_mj"] = importlib.util.module_from_spec(_spec)  # made, and not executed
