"""Order of the tests: the longest come first, so that no worker is left alone with them."""

from pathlib import Path

EXPERIMENTS = Path(__file__).parent / "experiments"


def pytest_collection_modifyitems(items):
    items.sort(key=lambda item: EXPERIMENTS not in item.path.parents)
