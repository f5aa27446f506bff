"""Headers as other programs write them are refused with what is to be changed."""

import pytest

from tendon_mj.errors import RecordingError
from tendon_mj.recordings.table_checks import check_names


@pytest.mark.parametrize(
    ("header", "says"),
    [
        (['"time_ms"', '"spool_deg"'], "write the names without quotes"),
        (["time", "spool_deg"], "say its unit: 'time_s', 'time_ms'"),
        (["t", "spool_deg"], "say its unit"),
        (["time_s", "lever_degrees"], "did you mean '_deg'?"),
        (["time_s", "cable_newtons"], "did you mean '_N'?"),
    ],
)
def test_the_way_out_is_in_the_message(header, says):
    with pytest.raises(RecordingError, match=says.replace("?", r"\?")):
        check_names(header, "pull.csv")
