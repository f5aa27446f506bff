"""Pictures: clips of a model in motion, and figures that hold it against theory and measurement."""

from tendon_mj.view.figures.loops import bench_loops_figure as bench_loops_figure
from tendon_mj.view.figures.style import BLACK as BLACK
from tendon_mj.view.figures.style import BLUE as BLUE
from tendon_mj.view.figures.style import GREEN as GREEN
from tendon_mj.view.figures.style import GREY as GREY
from tendon_mj.view.figures.style import ORANGE as ORANGE
from tendon_mj.view.figures.style import PURPLE as PURPLE
from tendon_mj.view.figures.style import SERIES as SERIES
from tendon_mj.view.figures.style import SKY as SKY
from tendon_mj.view.figures.style import VERMILLION as VERMILLION
from tendon_mj.view.figures.style import legend_below as legend_below
from tendon_mj.view.figures.style import new_figure as new_figure
from tendon_mj.view.figures.style import print_style as print_style
from tendon_mj.view.render.clip import render_clip as render_clip
from tendon_mj.view.render.offscreen import Offscreen as Offscreen
from tendon_mj.view.render.offscreen import find_camera as find_camera
from tendon_mj.view.render.panel import INK as INK
