"""`tendon-mj view` in a window on a screen of its own, and as a page."""

import os
import shutil
import subprocess
import sys

import pytest

from tendon_mj.cli import main
from tests.show.live.test_web import ROOT, free_port

PATIENCE = 180.0  # [s]


def view(*arguments, **environment):
    command = [sys.executable, "-m", "tendon_mj", "view", *arguments]
    return subprocess.run(
        command,
        env={**os.environ, **environment},
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=PATIENCE,
    )


@pytest.fixture
def screen():
    """Name of a screen that nobody sees."""
    program = shutil.which("Xvfb")
    if program is None:
        pytest.skip("there is no Xvfb here")
    reads, writes = os.pipe()
    flags = ["-displayfd", str(writes), "-screen", "0", "800x600x24", "+extension", "GLX"]
    server = subprocess.Popen([program, *flags], pass_fds=[writes], stderr=subprocess.DEVNULL)
    os.close(writes)
    with os.fdopen(reads) as told:
        yield f":{told.readline().strip()}"
    server.terminate()
    server.wait()


def test_a_window_opens_and_says_how_well_it_kept_real_time(screen):
    done = view("finger", "--seconds", "2", DISPLAY=screen, LIBGL_ALWAYS_SOFTWARE="1")
    if "could not open" in done.stderr or "GLX" in done.stderr:
        pytest.skip(f"nothing can be drawn on that screen: {done.stderr}")
    assert done.returncode == 0, done.stderr
    assert "× real time" in done.stdout
    assert not done.stderr


def test_a_page_is_served_for_the_time_that_is_asked_for():
    pytest.importorskip("mjviser")
    done = view("bench", "--web", "--port", str(free_port()), "--seconds", "1")
    assert done.returncode == 0, done.stderr
    first, last = done.stdout.splitlines()
    assert first.startswith("http://localhost:")
    assert "× real time" in last


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--seconds", "-1"], "--seconds -1 must be greater than 0"),
        (["--web", "--port", "99999"], "--port 99999: ports go from 0, any that is free, to 65535"),
        (["--web", "--port", "-1"], "--port -1: ports go from 0"),
        (["--motion", "curl"], "a CSV with time_s and a column for each actuator"),
    ],
)
def test_odd_arguments_are_refused_in_a_line(arguments, said, capsys):
    pytest.importorskip("mjviser")
    assert main(["view", "bench", *arguments]) == 2
    assert said in " ".join(capsys.readouterr().err.split())


def test_an_unknown_motion_is_refused_in_a_line(capsys):
    assert main(["view", "finger", "--motion", "curls"]) == 2
    assert "did you mean 'curl'" in capsys.readouterr().err
