"""The plugin `tendon_mj.sheath`."""

from tendon_mj.plugin.sheath_plugin.attributes import ATTACHMENT as ATTACHMENT
from tendon_mj.plugin.sheath_plugin.attributes import INPUT_ENDS as INPUT_ENDS
from tendon_mj.plugin.sheath_plugin.attributes import KINDS as KINDS
from tendon_mj.plugin.sheath_plugin.attributes import NAME as NAME
from tendon_mj.plugin.sheath_plugin.attributes import SPRINGS as SPRINGS
from tendon_mj.plugin.sheath_plugin.attributes import is_one_number as is_one_number
from tendon_mj.plugin.sheath_plugin.bind import attachment as attachment
from tendon_mj.plugin.sheath_plugin.drive import CHOSEN_STIFFNESS as CHOSEN_STIFFNESS
from tendon_mj.plugin.sheath_plugin.state import PARAMETERS as PARAMETERS
from tendon_mj.plugin.sheath_plugin.state import STATE as STATE
from tendon_mj.plugin.sheath_plugin.state import View as View
from tendon_mj.plugin.sheath_plugin.state import size_of as size_of
from tendon_mj.plugin.sheath_plugin.state import view as view
from tendon_mj.plugin.sheath_plugin.visualize import MARK as MARK
from tendon_mj.plugin.sheath_plugin.visualize import SLIPPING as SLIPPING
from tendon_mj.plugin.sheath_plugin.visualize import TENSION_SCALE as TENSION_SCALE
from tendon_mj.plugin.sheath_plugin.visualize import THICKER as THICKER
from tendon_mj.plugin.sheath_plugin.visualize import check_limits as check_limits
from tendon_mj.plugin.sheath_plugin.visualize import check_tension_scale as check_tension_scale
