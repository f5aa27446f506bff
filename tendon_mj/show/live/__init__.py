"""Simulations to watch while they run: in MuJoCo's viewer, or in a browser."""

from tendon_mj.show.live.own_loop import view as view
from tendon_mj.show.live.session import prepare as prepare
from tendon_mj.show.live.web import serve as serve
from tendon_mj.show.live.window import Viewer as Viewer
from tendon_mj.show.live.window import check_screen as check_screen
from tendon_mj.show.live.window import open_window as open_window
