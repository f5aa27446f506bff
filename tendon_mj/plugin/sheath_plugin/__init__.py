"""The plugin `tendon_mj.sheath`."""

from tendon_mj.plugin.sheath_plugin.attributes import ATTACHMENT as ATTACHMENT
from tendon_mj.plugin.sheath_plugin.attributes import INPUT_ENDS as INPUT_ENDS
from tendon_mj.plugin.sheath_plugin.attributes import KINDS as KINDS
from tendon_mj.plugin.sheath_plugin.attributes import NAME as NAME
from tendon_mj.plugin.sheath_plugin.attributes import SPRINGS as SPRINGS
from tendon_mj.plugin.sheath_plugin.bind import attachment as attachment
from tendon_mj.plugin.sheath_plugin.state import PARAMETERS as PARAMETERS
from tendon_mj.plugin.sheath_plugin.state import STATE as STATE
from tendon_mj.plugin.sheath_plugin.state import View as View
from tendon_mj.plugin.sheath_plugin.state import size_of as size_of
from tendon_mj.plugin.sheath_plugin.state import view as view
from tendon_mj.plugin.sheath_plugin.visualize import check_tension_scale as check_tension_scale
