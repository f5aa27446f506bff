"""Pictures in a light and a dark variant, written for GitHub as `<picture>`."""

import re

_PICTURE = re.compile(
    r'<picture>\s*<source media="\(prefers-color-scheme: dark\)" srcset="([^"]+)">\s*'
    r'<img alt="([^"]+)" src="([^"]+)">\s*</picture>'
)
_BOTH = """```{{image}} {light}
:alt: {alt}
:class: only-light
```
```{{image}} {dark}
:alt: {alt}
:class: only-dark
```"""


def _convert(app, page: str, source: list[str]) -> None:
    source[0] = _PICTURE.sub(
        lambda found: _BOTH.format(dark=found[1], alt=found[2], light=found[3]), source[0]
    )


def setup(app):
    """Convert the pictures when a page is read."""
    app.connect("source-read", _convert)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
