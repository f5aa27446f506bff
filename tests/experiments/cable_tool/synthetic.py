"""A tool that was made up: friction acts forward, from a load that is given to the input torque."""

import numpy as np

from experiments.cable_tool.recording import ToolRecording
from experiments.cable_tool.tool import Tool

TOOL = Tool(
    friction_exponent=0.42,
    wrist_friction=0.05,
    closing_offset=0.031,
    load_difference=0.004,
    stiffness=0.012,
    take_up=0.2,
    angle_ratio=0.93,
    compliance=1.1,
)
BACKLASH = 0.06  # travel of the input over which friction turns round [rad]
AMPLITUDE = 0.52  # [rad]


def made_up(
    load,
    pitch=0,
    roll=0,
    tool=TOOL,
    opening_offset=-0.045,
    seconds_per_period=4.0,
    periods=3,
    output_zero=0.7,
):
    """A recording of ``tool`` under a load [N m]; pitch and roll in steps of the file names.

    Friction's share f, 1 when closing and −1 when opening, follows the input over the backlash;
    T_in = x e^{fλ} + (b_c + b_o)/2 + f (b_c − b_o)/2 − k φ.
    """
    pitches, rolls = pitch * np.pi / 6, roll * np.pi / 4
    time = np.arange(0.0, periods * seconds_per_period, 0.02 * seconds_per_period / 4.0)
    excursion = AMPLITUDE * np.cos(2.0 * np.pi * time / seconds_per_period)
    share = np.empty_like(time)
    now = -1.0
    before = excursion[-1]
    for i, angle in enumerate(excursion):
        now = np.clip(now - (angle - before) / (0.5 * BACKLASH), -1.0, 1.0)
        share[i], before = now, angle
    exponent = tool.friction_exponent + tool.wrist_friction * pitches
    carried = load + 0.5 * tool.load_difference * share - 0.003 * excursion
    mean = 0.5 * (tool.closing_offset + opening_offset)
    constant = 0.5 * (tool.closing_offset - opening_offset)
    torque = carried * np.exp(share * exponent) + mean + share * constant
    angle = excursion + 1.0
    stretch = tool.compliance * (carried + 0.5 * share * constant)
    return ToolRecording(
        name=f"made up {load} {pitch} {roll}",
        pose=f"pitch{pitch + 3}" if pitch else f"roll{roll + 3}" if roll else "straight",
        pitch=pitches,
        roll=rolls,
        load_share=load / 0.12,
        rate="",
        time=time,
        input_angle=angle,
        input_torque=torque - tool.stiffness * excursion,
        output_angle=output_zero - tool.angle_ratio * angle - stretch,
        load=carried,
    )


def suite(tool=TOOL):
    """Three loads on a straight wrist, two each on wrists that are bent; offsets differ."""
    straight = [made_up(load, tool=tool) for load in (0.02, 0.06, 0.1)]
    pitched = [
        made_up(load, pitch=pitch, tool=tool, opening_offset=-0.045 - 0.004 * pitch)
        for load in (0.03, 0.09)
        for pitch in (-2, 2)
    ]
    rolled = [
        made_up(load, roll=2, tool=tool, opening_offset=-0.055, output_zero=0.2)
        for load in (0.05, 0.08)
    ]
    return [*straight, *pitched, *rolled]
