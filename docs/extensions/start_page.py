"""`index.html` at the root of the site, which leads to the start page beside the guides."""

from pathlib import Path

_REDIRECT = """<!doctype html>
<html lang="en">
<meta charset="utf-8">
<title>{title}</title>
<meta http-equiv="refresh" content="0; url={page}.html">
<a href="{page}.html">{title}</a>
</html>
"""


def _write(app, failure) -> None:
    if failure is None and app.builder.format == "html":
        text = _REDIRECT.format(title=app.config.html_title, page=app.config.root_doc)
        (Path(app.outdir) / "index.html").write_text(text, "utf-8")


def setup(app):
    """Write the page when all others are there."""
    app.connect("build-finished", _write)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
