"""The library that draws a report's charts, small enough to travel in the page itself."""

from __future__ import annotations

import base64
import gzip
from functools import cache

from plotly.offline import get_plotlyjs


@cache
def packed_plotly() -> str:
    """plotly.js, compressed with gzip, in base64: 2 of its 4.8 MB; a browser unpacks it itself."""
    return base64.b64encode(gzip.compress(get_plotlyjs().encode(), 9, mtime=0)).decode("ascii")
