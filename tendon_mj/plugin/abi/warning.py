"""A warning of MuJoCo's from compiled code, which goes where the user sends them.

`mju_warning` takes a format as `printf` does, with as many values as it asks for. Ours asks for
none: the text is put together here, and a percent sign in a name is doubled.
"""

from __future__ import annotations

from tendon_mj.compilation import compiled
from tendon_mj.plugin.abi.library import mju_warning
from tendon_mj.plugin.abi.memory import byte, local_doubles, set_byte

_SIZE = 512  # bytes of a message, with the zero that ends it
_PERCENT = 37
_INNER, _FIRST = 128, 192  # of a letter's bytes in UTF-8, all but the first lie between these
_buffer = local_doubles(_SIZE // 8)


@compiled
def _append(message: int, used: int, text: int, limit: int) -> int:
    """Copy a text, or what fits of it, behind what is there; returns how many bytes are used."""
    index = 0
    letter = byte(text, 0)
    while letter != 0 and used < limit - 1:
        set_byte(message + used, letter)
        used += 1
        if letter == _PERCENT:
            set_byte(message + used, letter)
            used += 1
        index += 1
        letter = byte(text, index)
    if _INNER <= letter < _FIRST:  # no letter is cut in two
        while used > 0 and _INNER <= byte(message, used - 1) < _FIRST:
            used -= 1
        used -= 1
    return used


@compiled
def warn(before: int, name: int, after: int) -> None:
    """Warn with a text, a name, and a text; each at an address, ended by a zero."""
    message = _buffer()
    used = _append(message, 0, before, _SIZE // 4)
    used = _append(message, used, name, _SIZE // 2)
    used = _append(message, used, after, _SIZE - 1)
    set_byte(message + used, 0)
    mju_warning(message)
