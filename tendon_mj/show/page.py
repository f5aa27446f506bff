"""Templates of pages: one file without network, and every text that comes from a file escaped."""

from __future__ import annotations

from jinja2 import Environment, PackageLoader, StrictUndefined


def page_templates() -> Environment:
    """The templates of the pages, which extend ``base.html``."""
    return Environment(
        loader=PackageLoader("tendon_mj.show"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
