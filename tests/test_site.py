"""The site builds without a warning, its links lead somewhere, and it has what it should have."""

import json
import os
import re
import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

import pytest

import tendon_mj
from tendon_mj.cli import COMMANDS

ROOT = Path(__file__).parents[1]
PICTURES = (".png", ".webp", ".gif", ".jpg", ".svg")
GUIDES = {
    "install": "README",
    "bowden": "README",
    "backlash": "docs/plugin",
    "hysteresis": "docs/theory",
    "csv format": "docs/recording",
    "rosbag": "docs/recording",
    "identifiability": "docs/diagnosis",
    "gpu": "docs/gpu",
}


class Page(HTMLParser):
    """What a page refers to, and the anchors that it has."""

    def __init__(self, text):
        super().__init__()
        self.links, self.loaded, self.anchors, self.words = [], [], set(), []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        given = dict(attributes)
        self.anchors |= {given[key] for key in ("id", "name") if given.get(key)}
        if tag == "a" and given.get("href"):
            self.links.append(given["href"])
        if tag == "link" and given.get("rel") in ("stylesheet", "icon"):
            self.loaded.append(given["href"])
        if tag in ("img", "script", "iframe", "video", "source") and given.get("src"):
            self.loaded.append(given["src"])

    def handle_data(self, data):
        self.words.append(data)


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """Folder of the built site → its pages, by their paths."""
    pytest.importorskip("sphinx", reason="the extra tendon-mj[docs] is not installed")
    out = tmp_path_factory.mktemp("site")
    command = ["-m", "sphinx", "-q", "-W", "--keep-going", "-c", str(ROOT / "docs"), str(ROOT)]
    done = subprocess.run(
        [sys.executable, *command, str(out)], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return {path: Page(path.read_text("utf-8")) for path in sorted(out.rglob("*.html"))}


def target(page, reference):
    """File and anchor that a reference of a page means; None for one that leads elsewhere."""
    parts = urlsplit(reference)
    if parts.scheme or parts.netloc:
        return None
    path = (page.parent / unquote(parts.path)).resolve() if parts.path else page
    return path, unquote(parts.fragment)


def test_every_link_and_anchor_and_all_that_a_page_loads_lead_somewhere(site):
    dead, loaded = [], 0
    for path, page in site.items():
        loaded += len(page.loaded)
        for reference in (*page.links, *page.loaded):
            if urlsplit(reference).scheme == "data":
                continue
            goal = target(path, reference)
            if goal is None:
                elsewhere = reference in page.loaded  # what is shown is in the site
                dead += [f"{path.name}: {reference}"] if elsewhere else []
                continue
            file, anchor = goal
            if not file.is_file() or (file in site and anchor not in {"", *site[file].anchors}):
                dead.append(f"{path.name}: {reference}")
    assert not dead
    assert loaded > 50  # else it proves nothing


def test_the_search_lists_the_guide_of_a_word_first(site):
    root = next(path.parent for path in site if path.name == "search.html")
    text = (root / "searchindex.js").read_text("utf-8")
    index = json.loads(text[text.index("{") : text.rindex("}") + 1])
    for word, page in GUIDES.items():
        pages = [index["docnames"][k] for k, _, is_main in index["indexentries"][word] if is_main]
        assert pages == [page], word


def test_every_public_name_command_and_example_has_its_place(site):
    reference = set().union(*(p.anchors for path, p in site.items() if path.match("docs/api/*")))
    names = set(tendon_mj.__all__) - {"__version__"}
    assert {name for name in names if f"tendon_mj.{name}" not in reference} == set()
    (commands,) = (p for path, p in site.items() if path.match("docs/commands.html"))
    assert set(COMMANDS) <= commands.anchors
    shown = (ROOT / "docs" / "examples.md").read_text("utf-8")
    for path in (ROOT / "examples").glob("*.py"):
        assert f"../examples/{path.name}" in shown


def test_the_gallery_has_every_picture_and_its_command():
    text = (ROOT / "docs" / "gallery.md").read_text("utf-8")
    pictures = [
        path
        for folder in ("docs", "docs/gallery", "models/*")
        for path in ROOT.glob(f"{folder}/*")
        if path.suffix in PICTURES
        and not path.stem.endswith("_dark")  # of a light one that is there
    ]
    names = {Path(os.path.relpath(path, ROOT / "docs")).as_posix() for path in pictures}
    shown = set(re.findall(r'<img alt="[^"]+" src="([^"]+)"', text))
    assert names == shown
    for section in re.split(r"^#+ ", text, flags=re.M)[1:]:
        if "<img" in section:
            assert "```sh\n" in section, section.splitlines()[0]


def test_defaults_are_named_where_their_values_would_fill_a_page(site):
    page = next(page for path, page in site.items() if path.match("docs/api/diagnosis.html"))
    text = "".join(page.words)
    assert "Iterable[Effect] = CATALOGUE" in text
    assert "Effect(identifier" not in text
    assert "<function" not in text
