"""The plugin `tendon_mj.servo`."""

from tendon_mj.plugin.force_servo_plugin.state import FEEDBACKS as FEEDBACKS
from tendon_mj.plugin.force_servo_plugin.state import GAINS as GAINS
from tendon_mj.plugin.force_servo_plugin.state import SERVO as SERVO
from tendon_mj.plugin.force_servo_plugin.state import SWITCH as SWITCH
from tendon_mj.plugin.force_servo_plugin.state import OptionalGains as OptionalGains
from tendon_mj.plugin.force_servo_plugin.state import check_gain as check_gain
