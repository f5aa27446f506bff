"""Models of others that cannot be loaded are refused by file and cause."""

import pytest

from tendon_mj.builders.load import load_model, model_path
from tendon_mj.errors import TendonError


def test_a_name_that_is_not_utf_8_says_so(tmp_path):
    text = model_path("bench").read_text("utf-8").replace('"tendon"', '"fléxor"')
    path = tmp_path / "latin.xml"
    path.write_text(text, encoding="latin-1")
    with pytest.raises(TendonError, match=r"latin\.xml: .* byte 0xe9, which is not UTF-8"):
        load_model(str(path))
