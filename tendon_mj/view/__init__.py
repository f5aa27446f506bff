"""Figures, reports and clips: data in, pictures out. Nothing here steps a simulation."""

from tendon_mj.view.figures.before_after import before_after_figure as before_after_figure
from tendon_mj.view.figures.finger import finger_figure as finger_figure
from tendon_mj.view.figures.loops import loops_figure as loops_figure
from tendon_mj.view.figures.replay import replay_figure as replay_figure
from tendon_mj.view.figures.sweep import sweep_figure as sweep_figure
from tendon_mj.view.render.clip import render_clip as render_clip
from tendon_mj.view.render.window import open_window as open_window
from tendon_mj.view.report.figures import diagnosis_figures as diagnosis_figures
from tendon_mj.view.report.report import report_page as report_page
