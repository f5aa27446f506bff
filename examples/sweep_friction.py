"""Sweep the friction of a Bowden cable, and plot output against input tension.

The tension that arrives lags behind the one that is put in: a loop of hysteresis, whose sides
have the slopes of the capstan equation, T_out = T_in e^{±μφ}, and between them a dead zone in
which the output does not move. Writes `sweep_friction.png`.
"""

import matplotlib.pyplot as plt
import mujoco
import numpy as np

import tendon_mj

BEND, LENGTH, PRETENSION = np.pi, 0.5, 20.0  # of the cable [rad], [m], [N]
STROKE, PERIOD, CYCLES = 0.4e-3, 2.0, 2.5  # of the input [m], [s]


def cable(friction):
    """A cable in a sheath bent by half a turn, wound in by a reel and held at its end."""
    spec = mujoco.MjSpec()
    points = tendon_mj.arc_points(length=LENGTH, bend=BEND, guides=32)
    tendon_mj.add_tendon(spec, "cable", tendon_mj.add_sites(spec, "guide", points))
    tendon_mj.add_friction(
        spec, "cable", friction=friction, axial_stiffness=20e3, pretension=PRETENSION, reel="reel"
    )
    return spec.compile()


def loop(friction):
    """Input and output tension [N] of a slow motion to and fro."""
    model = cable(friction)
    data = mujoco.MjData(model)
    tensions = []
    for _ in range(round(CYCLES * PERIOD / model.opt.timestep)):
        data.ctrl[0] = STROKE * np.sin(2.0 * np.pi * data.time / PERIOD)
        mujoco.mj_step(model, data)
        tensions.append([data.sensor(f"{end}_tension").data[0] for end in ("input", "output")])
    return np.array(tensions).T


plt.style.use("tableau-colorblind10")
figure, axes = plt.subplots(figsize=(5, 4.5), layout="constrained")
for friction in (0.05, 0.15, 0.3):
    put_in, arrived = loop(friction)
    axes.plot(put_in, arrived, label=f"friction {friction:g}")
    ratio = arrived[-1000:] / put_in[-1000:]
    print(
        f"friction {friction:4.2f}: T_out/T_in from {ratio.min():.3f} to {ratio.max():.3f}, by the "
        f"capstan equation {np.exp(-friction * BEND):.3f} to {np.exp(friction * BEND):.3f}"
    )
axes.set(xlabel="input tension [N]", ylabel="output tension [N]", title="A sheath bent by 180°")
axes.legend()
figure.savefig("sweep_friction.png", dpi=150)
print("wrote sweep_friction.png, tensions in N")
