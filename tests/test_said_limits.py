"""What a structure's file may hold has limits, which are said, and texts that readers stumble over are answered."""

from pathlib import Path
from typing import Any

import pytest

from fe_models.errors import InputError
from fe_models.files.models import load_model
from tests.odd_inputs import within
from tests.test_odd_inputs import PORTAL, as_toml


@pytest.mark.parametrize(
    ("change", "fault"),
    [
        ({"divisions": 10**18}, "divisions: is an integer beyond"),
        ({"divisions": 10**9}, "the structure has 3000000002 finite elements with divisions = 1000000000"),
        pytest.param(
            {"nodes": [[0.0, 0.0]] * 100_001},
            "nodes: has 100001 items; at most 100000 are read",
            marks=pytest.mark.slow,  # reading them takes seconds
        ),
        ({"directions": []}, "directions: there are none"),
        ({"nodes": 5}, "nodes: expected a list, found 5"),
        ({"sections": [5]}, "sections[1]: expected a table, found 5"),
        ({"elements": ["kind"]}, 'elements[1]: expected a table, found "kind"'),
        ({"name": "\x1b]0;x\x07"}, "name: holds a control character"),
        ({"name": "x" * 10**6}, "name: has 1000000 characters; at most 1000 are read"),
    ],
)
def test_limits_are_said(change: dict[str, Any], fault: str, tmp_path: Path) -> None:
    (tmp_path / "big.toml").write_text(as_toml(PORTAL | change))
    with pytest.raises(InputError) as caught:
        load_model(str(tmp_path / "big.toml"))
    assert any(fault in each for each in caught.value.faults), caught.value.faults[:3]


@pytest.mark.parametrize(
    "text", ["a." * 100_000 + "a = 1", "a = " + "[" * 50_000, "a = " + "9" * 5000, "[" + "b." * 5000 + "b]"]
)
def test_texts_that_readers_stumble_over(text: str, tmp_path: Path) -> None:
    (tmp_path / "deep.toml").write_text(text)
    with within(), pytest.raises(InputError, match=r"deep.toml: not valid TOML"):
        load_model(str(tmp_path / "deep.toml"))
