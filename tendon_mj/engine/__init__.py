"""The engine plugins: `sheath_plugin`, and `servo_plugin`, which uses it."""

from tendon_mj.engine.instances import Instance as Instance
from tendon_mj.engine.instances import segment_tensions as segment_tensions
from tendon_mj.engine.instances import sensor_kind as sensor_kind
from tendon_mj.engine.instances import servo_estimate as servo_estimate
from tendon_mj.engine.instances import servos as servos
from tendon_mj.engine.instances import sheath_arrays as sheath_arrays
from tendon_mj.engine.instances import sheaths as sheaths
from tendon_mj.engine.instances import unsolved_evaluations as unsolved_evaluations
from tendon_mj.engine.plugin import register as register
from tendon_mj.engine.servo_plugin.gains import GAINS as GAINS
from tendon_mj.engine.servo_plugin.gains import OptionalGains as OptionalGains
from tendon_mj.engine.servo_plugin.gains import check_gain as check_gain
from tendon_mj.engine.servo_plugin.state import FEEDBACKS as FEEDBACKS
from tendon_mj.engine.servo_plugin.validate import SERVO as SERVO
from tendon_mj.engine.sheath_plugin.attributes import INPUT_ENDS as INPUT_ENDS
from tendon_mj.engine.sheath_plugin.attributes import SPRINGS as SPRINGS
from tendon_mj.engine.sheath_plugin.binding.own_names import prefix_and_suffix as prefix_and_suffix
from tendon_mj.engine.sheath_plugin.driven import CHOSEN_STIFFNESS as CHOSEN_STIFFNESS
from tendon_mj.engine.sheath_plugin.sensors import KINDS as KINDS
from tendon_mj.engine.sheath_plugin.sensors import is_one_number as is_one_number
from tendon_mj.engine.sheath_plugin.state import PARAMETERS as PARAMETERS
from tendon_mj.engine.sheath_plugin.tension_scale import TENSION_SCALE as TENSION_SCALE
from tendon_mj.engine.sheath_plugin.tension_scale import check_limits as check_limits
from tendon_mj.engine.sheath_plugin.validation.drive import unused_parameters as unused_parameters
from tendon_mj.engine.sheath_plugin.validation.sheath import NAME as NAME
