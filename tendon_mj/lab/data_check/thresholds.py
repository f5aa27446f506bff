"""Thresholds of the checks; tests hold each at its edge (`tests/lab/data_check`)."""

import math
from typing import Final

# shares
LITTLE: Final = 0.1  # of a range, a turn or an interval: less makes no difference
PART: Final = 0.3  # of a jump: what explains more of it explains it
OUTER: Final = 0.01  # of the samples: outliers, which do not count for a range
ROUNDING: Final = 1e-6  # of a size
STILL: Final = 1e-4  # of its range, by which a drive at rest moves

# noise
SIGMAS: Final = 3.0  # standard deviations that are no noise, of a series
CLEAR: Final = 8.0  # the same of a single sample among all
ALIKE: Final = 1.3  # ratio of two rms errors that may be the same
NEARER: Final = 3.0  # ratio of two errors, from which on columns are exchanged
BETTER: Final = 0.25  # of the power of an error, which a better explanation leaves at most
VISIBLE: Final = math.sqrt(1.1**2 - 1.0)  # noises that leave a diagnosis more than 1.1 of them
OVERSTATED: Final = 10.0  # times the noise from sample to sample; slow noise is several times it
SCATTER: Final = 1.5  # times the noise, by which a column scatters at rest that has more
VISIBLE_STEP: Final = 2.5e-3  # of a range, where no noise is stated

# samples
SHORT: Final = 5  # that a start, a dropout, or a drive that is held between commands lasts
AROUND: Final = 2  # that a spike lasts, or lie between cause and effect
SIDE: Final = 8  # on either side of a jump that are nearly a line; a rig reacts within these
LONG: Final = 200  # on either side of a jump, for which it stays
ENOUGH: Final = 100  # for statistics of the whole recording
LEVEL: Final = 20  # for a standard deviation
REST: Final = 40  # for one of what is left beside a slow motion
HELD: Final = 10  # that are equal to the last digit
RESTS: Final = 4  # that are equal to the last digit

# times
SLOW: Final = 0.5  # interval [s] from which rows were read one by one, or times are in ms
FAST: Final = 5e-5  # interval [s] below which times may be in a larger unit …
BRIEF: Final = 0.5  # … if the recording is as short as this [s]
GAP: Final = 5.0  # times the median interval
UNSEEN: Final = 0.02  # of a drive's range, by which it may leave a line in a gap
LONG_SETTLE: Final = 60.0  # [s] that no rig needs to come to rest

# jumps and steps
OFTEN, STEP = 90.0, 3.0  # percentile of changes, and times it, from which on one is a step
JUMPS: Final = 2  # of a column: more are how the rig moves
BITS: Final = 8  # of a counter, at least

# readings against the model
SIMILAR: Final = 0.15  # of a range, by which a start or a motion of the same kind may differ
ALIKE_IN_SHAPE: Final = 0.7  # correlation of a column and the model below which they are unlike
SAME_SHAPE: Final = 0.98  # correlation of a column and the model that differ by a factor
DEGREES: Final = 1.5  # ratio to 180/π, or to g, of ranges that differ by it: friction is no factor
THOUSAND: Final = 100.0  # ratio of two ranges from which it may be 1000
HARDLY: Final = 3000.0  # ratio of two ranges that no mistaken unit explains
ALL: Final = 5.0  # ratio from which a unit is meant: the drive's if every column is off by it
TURNED: Final = 3.0  # range of angles that may be degrees [rad]; less of these would be no motion
FLANK: Final = 0.03  # of a play, by which the drum may stand off
