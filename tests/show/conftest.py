import pytest

from tendon_mj.errors import EngineError
from tendon_mj.show.render.offscreen import make_context


@pytest.fixture(scope="session")
def gl():
    """Skips what draws a scene on a machine that has nothing to draw with."""
    try:
        make_context(64, 64).free()
    except EngineError as error:
        pytest.skip(f"no clip can be drawn here: {error}")
