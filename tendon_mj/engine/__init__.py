"""The engine plugin and the C ABI: the only room that knows a struct offset."""

from tendon_mj.engine.measure import KINDS as KINDS
from tendon_mj.engine.plugin import register as register
from tendon_mj.engine.validate import NAME as NAME
