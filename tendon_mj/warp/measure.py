"""The kernel that writes what sensors of sheaths show."""

import warp as wp

from tendon_mj.warp.tendons import Tendons

wp.set_module_options({"enable_backward": False})

TENSION, ANGLE, SLIP, WOUND, UNSOLVED = range(5)


@wp.kernel
def measure(t: Tendons, shown: wp.array2d[wp.int32], sensordata: wp.array2d[wp.float32]) -> None:
    """Write each number that is shown, see `sensors`; threads (numbers, worlds)."""
    k, w = wp.tid()
    quantity, row = shown[k, 0], shown[k, 1]
    value = wp.float32(0.0)
    if quantity == TENSION:
        value = t.tension_out[w, row]
    elif quantity == ANGLE:
        value = wp.float32(t.angle[row, w])
    elif quantity == SLIP:
        if t.flow[row, w] != wp.float64(0.0):
            value = wp.float32(t.slip[row, w])
    elif quantity == WOUND:
        value = wp.float32(t.trial_wound_in[row, w])
    else:
        value = wp.float32(t.unsolved[w, row])
    sensordata[w, shown[k, 2]] = value
