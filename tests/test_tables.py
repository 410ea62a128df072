"""A TOML table becomes a dataclass, or a list of all that is wrong with it."""

import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from fe_models.errors import InputError
from fe_models.files.tables import read_table, read_toml
from fe_models.files.toml_text import toml_text


@dataclass(frozen=True)
class Gauge:
    """One of each kind of value."""

    name: str
    node: int
    gain: float
    direction: Literal["x", "y"] = "x"
    nodes: tuple[int] | tuple[int, int] = (1,)
    ratios: tuple[float, ...] = ()
    active: bool = True
    limit: float | None = None


GOOD: dict[str, Any] = {"name": "A1", "node": 5, "gain": 1.5}


def read(table: dict[str, Any]) -> tuple[Gauge | None, list[str]]:
    faults: list[str] = []
    return read_table(Gauge, table, "f.toml: gauges[2]", faults), faults


def test_a_good_table_becomes_the_dataclass() -> None:
    table = GOOD | {"nodes": [3, 4], "ratios": [0.1, 1], "gain": 2, "limit": 3}
    assert read(table) == (Gauge("A1", 5, 2.0, nodes=(3, 4), ratios=(0.1, 1.0), limit=3.0), [])


@pytest.mark.parametrize(
    ("change", "fault"),
    [
        ({"node": 5.0}, ".node: expected an integer, found 5.0"),
        ({"node": "5"}, '.node: expected an integer, found "5"'),
        ({"node": True}, ".node: expected an integer, found true"),
        ({"gain": "1"}, '.gain: expected a number, found "1"'),
        ({"gain": False}, ".gain: expected a number, found false"),
        ({"gain": float("nan")}, ".gain: expected a number, found NaN"),
        ({"gain": float("inf")}, ".gain: expected a number, found Infinity"),
        ({"gain": tomllib.loads("d = 2020-01-01")["d"]}, '.gain: expected a number, found "2020-01-01"'),
        ({"name": 3}, ".name: expected text, found 3"),
        ({"active": 1}, ".active: expected true or false, found 1"),
        ({"direction": "z"}, '.direction: expected "x" or "y", found "z"'),
        ({"nodes": [1, 2, 3]}, ".nodes: expected [an integer] or [an integer, an integer], found [1, 2, 3]"),
        ({"ratios": [0.1, "a"]}, '.ratios: expected [a number, ...], found [0.1, "a"]'),
        ({"limit": {}}, ".limit: expected a number, found {}"),
        ({"directoin": "x"}, ".directoin: unknown key; did you mean 'direction'?"),
        ({"colour": "x"}, ".colour: unknown key; expected one of name, node, gain, direction"),
    ],
)
def test_a_bad_value_is_named_with_its_place(change: dict[str, Any], fault: str) -> None:
    result, faults = read(GOOD | change)
    assert (result is None) == (not change.keys().isdisjoint({"name", "node", "gain"}))  # else a default stands in
    assert len(faults) == 1
    assert faults[0].startswith("f.toml: gauges[2]" + fault)


def test_all_faults_come_out_at_once() -> None:
    result, faults = read({"nam": "A1", "node": "x", "direction": 3})
    assert result is None
    assert [fault.split(":")[1].strip() for fault in faults] == [
        f"gauges[2].{key}" for key in ("nam", "name", "node", "gain", "direction")
    ]
    assert "missing; expected a number" in faults[3]


@pytest.mark.parametrize("content", [b"a = 1\nb = = 2\n", b"a = 1\na = 2\n", b"a = 1\nb"])
def test_a_syntax_error_names_its_line(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "f.toml").write_bytes(content)
    with pytest.raises(InputError, match=r"f.toml: not valid TOML: .*(line 2|end of document)"):
        read_toml(tmp_path / "f.toml")


def test_unreadable_files_are_bad_input(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no such file"):
        read_toml(tmp_path / "none.toml")
    with pytest.raises(InputError, match="cannot be read"):
        read_toml(tmp_path)
    (tmp_path / "f.toml").write_bytes(b"a = '\xff'")
    with pytest.raises(InputError, match=r"not UTF-8 text \(byte 5\)"):
        read_toml(tmp_path / "f.toml")
    (tmp_path / "deep.toml").write_text("a = " + "[" * 100_000)
    with pytest.raises(InputError, match="not valid TOML"):
        read_toml(tmp_path / "deep.toml")


scalars = st.integers(-(2**60), 2**60) | st.floats(allow_nan=False) | st.text() | st.booleans()
rows = st.dictionaries(st.sampled_from(["a", "b", "long_key"]), scalars | st.lists(scalars, max_size=3), max_size=3)
documents = st.dictionaries(st.sampled_from(["x", "y", "z"]), scalars | st.lists(scalars) | st.lists(rows) | rows)


# Drawing texts for the first time builds Unicode tables, which can take seconds on a busy machine.
@settings(deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(documents)
def test_toml_text_reads_back_the_same(document: dict[str, Any]) -> None:
    assert repr(tomllib.loads(toml_text(document))) == repr(_tables_last(document))


def _tables_last(document: dict[str, Any]) -> dict[str, Any]:
    return dict(sorted(document.items(), key=lambda item: isinstance(item[1], dict)))
