"""Records share memory with what they are views of, in compiled code and in Python."""

import numpy as np
from numba import carray

from tendon_mj.compilation import compiled
from tendon_mj.plugin.abi.memory import record_at, records_pointer
from tendon_mj.sheath import SEGMENT, record_type


class Pair:
    law: float
    inner: "Inner"


class Inner:
    one: float
    two: float


def test_fields_follow_one_another_without_gaps():
    assert record_type(Inner).names == ("one", "two")
    assert record_type(Pair).itemsize == 3 * 8
    assert record_type(Pair).fields["inner"][1] == 8


def test_what_compiled_code_writes_is_in_the_array():
    pair_at, segments_at = record_at(record_type(Pair)), records_pointer(SEGMENT)

    @compiled
    def write(pair, segments, count):
        pair_at(pair).inner.two = 7.0
        for j in range(count):
            carray(segments_at(segments), count)[j].tension = j

    pair, segments = np.zeros(3), np.zeros(4, SEGMENT)
    write(pair.ctypes.data, segments.ctypes.data, 4)
    np.testing.assert_array_equal(pair, [0.0, 0.0, 7.0])
    np.testing.assert_array_equal(segments["tension"], np.arange(4.0))
    assert not segments["length"].any()
