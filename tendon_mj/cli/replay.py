"""`tendon-mj replay`: simulate what was measured, and show how far off it is."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import tyro

from tendon_mj.cli.output import Output, console, progress_bar
from tendon_mj.simulate.recording import read_recording, write_recording
from tendon_mj.simulate.replay import replay as simulate
from tendon_mj.simulate.replay import replay_error
from tendon_mj.view.replay import replay_figure
