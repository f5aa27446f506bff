"""Figures, reports and clips: data in, pictures out. Nothing here steps a simulation."""

from tendon_mj.view.figures.before_after import before_after_figure as before_after_figure
from tendon_mj.view.figures.finger import finger_figure as finger_figure
from tendon_mj.view.figures.loops import loops_figure as loops_figure
from tendon_mj.view.figures.replay import replay_figure as replay_figure
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
from tendon_mj.view.figures.sweep import sweep_figure as sweep_figure
from tendon_mj.view.render.clip import draw_frames as draw_frames
from tendon_mj.view.render.clip import render_clip as render_clip
from tendon_mj.view.render.offscreen import Offscreen as Offscreen
from tendon_mj.view.render.offscreen import find_camera as find_camera
from tendon_mj.view.render.panel import INK as INK
from tendon_mj.view.report.figures import diagnosis_figures as diagnosis_figures
from tendon_mj.view.report.page import report_page as report_page
from tendon_mj.view.report.write import write_report as write_report
