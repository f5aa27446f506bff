"""The C ABI of MuJoCo: struct offsets, memory, functions of its library."""

from tendon_mj.plugin.abi.draft import Draft as Draft
from tendon_mj.plugin.abi.layout import LAYOUT as LAYOUT
from tendon_mj.plugin.abi.layout import SCENE as SCENE
from tendon_mj.plugin.abi.layout import offset as offset
from tendon_mj.plugin.abi.layout import read as read
from tendon_mj.plugin.abi.layout import verify as verify
from tendon_mj.plugin.abi.layout import verify_scene as verify_scene
from tendon_mj.plugin.abi.layout import verify_state as verify_state
from tendon_mj.plugin.abi.library import C as C
from tendon_mj.plugin.abi.library import attribute_of as attribute_of
from tendon_mj.plugin.abi.library import plugin_at as plugin_at
