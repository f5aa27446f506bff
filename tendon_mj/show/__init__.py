"""Figures, reports, fleet pages and clips from data.

`show.live` has views of running simulations, `show.style` the colours of all figures.
"""

from tendon_mj.errors import MissingPackageError

try:
    from tendon_mj.show.figures.bench import bars_figure as bars_figure
    from tendon_mj.show.figures.bench import convergence_figure as convergence_figure
    from tendon_mj.show.figures.bench import loops_figure as loops_figure
    from tendon_mj.show.figures.bench import sweep_figure as sweep_figure
    from tendon_mj.show.figures.simulations import finger_figure as finger_figure
    from tendon_mj.show.figures.simulations import parameter_figure as parameter_figure
    from tendon_mj.show.figures.simulations import replay_figure as replay_figure
    from tendon_mj.show.fleets import CHANGES as CHANGES
    from tendon_mj.show.fleets import SPREAD as SPREAD
    from tendon_mj.show.fleets import changes_figure as changes_figure
    from tendon_mj.show.fleets import fleet_page as fleet_page
    from tendon_mj.show.fleets import spread_figure as spread_figure
    from tendon_mj.show.fleets import write_table as write_table
    from tendon_mj.show.live import view as view
    from tendon_mj.show.notebook import check as check
    from tendon_mj.show.notebook import fleet as fleet
    from tendon_mj.show.notebook import init as init
    from tendon_mj.show.notebook import plot_fit as plot_fit
    from tendon_mj.show.notebook import plot_misfit as plot_misfit
    from tendon_mj.show.notebook import plot_recording as plot_recording
    from tendon_mj.show.notebook import plot_sheath as plot_sheath
    from tendon_mj.show.notebook import show_clip as show_clip
    from tendon_mj.show.notebook import simulate as simulate
    from tendon_mj.show.notebook import sweep as sweep
    from tendon_mj.show.render.clip import check_size as check_size
    from tendon_mj.show.render.clip import draw_frames as draw_frames
    from tendon_mj.show.render.clip import render_clip as render_clip
    from tendon_mj.show.render.offscreen import Image as Image
    from tendon_mj.show.render.offscreen import Offscreen as Offscreen
    from tendon_mj.show.render.offscreen import find_camera as find_camera
    from tendon_mj.show.report.page import MODEL as MODEL
    from tendon_mj.show.report.page import first_screen as first_screen
    from tendon_mj.show.report.page import write_report as write_report
    from tendon_mj.show.report.text import ABSENT as ABSENT
    from tendon_mj.show.report.text import headline as headline
    from tendon_mj.show.report.text import value_rows as value_rows
except ModuleNotFoundError as error:
    raise MissingPackageError.of_lab("tendon_mj.show", error) from None
