"""Train a policy in 128 worlds at once, each with a friction of its own, on MuJoCo Warp.

A motor bends a knuckle through a sheath. The policy sets its pull from the angle that is missing,
its sum and the speed; the cross-entropy method tries each drawn policy in worlds of 8 frictions.
"""

import mujoco
import mujoco_warp
import numpy as np

import tendon_mj
import tendon_mj.warp

MODEL = """<mujoco>
  <option timestep="0.005" integrator="implicitfast"/>
  <worldbody>
    <site name="motor" pos="-0.3 0 -0.05"/><site name="wrist" pos="-0.1 0 0.02"/>
    <site name="knuckle" pos="-0.02 0 -0.01"/>
    <body>
      <joint name="knuckle" axis="0 1 0" stiffness="0.1" damping="0.01" armature="1e-4"/>
      <geom size="0.01" pos="0.03 0 0"/><site name="link" pos="0.02 0 -0.01"/>
    </body>
  </worldbody>
  <tendon><spatial name="flexor"><site site="motor"/><site site="wrist"/>
    <site site="knuckle"/><site site="link"/></spatial></tendon>
  <actuator><motor name="pull" tendon="flexor" ctrlrange="-30 0"/></actuator>
</mujoco>"""
POLICIES, ELITE, GENERATIONS, STEPS, WANTED = 16, 4, 3, 60, 0.4  # the last an angle [rad]
model = tendon_mj.add_friction(mujoco.MjSpec.from_string(MODEL), "flexor", friction=0.1).compile()
m = tendon_mj.warp.put_model(model)


def errors(policies, frictions):
    """(policies, frictions) mean error of the angle [rad] over the second half of an episode."""
    d = tendon_mj.warp.make_data(model, len(policies) * len(frictions))
    tendon_mj.warp.sheaths_of(d).set("friction", np.tile(frictions, len(policies))[:, None])
    gains = np.repeat(policies, len(frictions), axis=0)
    total, missed = np.zeros(d.nworld), []
    for _ in range(STEPS):
        error = WANTED - d.qpos.numpy()[:, 0]
        total += error * model.opt.timestep
        seen = np.column_stack([error, total, -d.qvel.numpy()[:, 0]])
        d.ctrl.assign(-np.maximum(0.0, (gains * seen).sum(axis=1, keepdims=True)))
        mujoco_warp.step(m, d)
        missed.append(np.abs(error))
    return np.mean(missed[STEPS // 2 :], axis=0).reshape(len(policies), len(frictions))


random = np.random.default_rng(0)
mean, spread = np.array([5.0, 5.0, 0.1]), np.array([10.0, 100.0, 0.5])
unseen = np.linspace(0.03, 0.47, 9)
before = errors(mean[None], unseen).mean()
for generation in range(GENERATIONS):
    drawn = np.abs(mean + spread * random.normal(size=(POLICIES, 3)))
    found = errors(drawn, random.uniform(0.0, 0.5, 8)).mean(axis=1)
    best = drawn[np.argsort(found)[:ELITE]]
    mean, spread = best.mean(axis=0), best.std(axis=0) + 1e-3
    print(f"generation {generation}: mean error of the best {np.rad2deg(found.min()):.2f} deg")
after = errors(mean[None], unseen).mean()
print(f"unseen frictions: {np.rad2deg(before):.1f} deg before, {np.rad2deg(after):.1f} after")
