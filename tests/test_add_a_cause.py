"""A cause is one file: the one that the documents show is hidden, named with its place, and written to files."""

import importlib.util
import re
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks.blind_cases import SENSORS
from fe_models.built_in.four_dof import four_dof
from fe_models.causes import CAUSES, CubicSpring
from fe_models.causes.base import Cause
from fe_models.errors import InputError
from fe_models.files.structure_file import load_structure, save_structure
from fe_models.recordings import Assumptions, Dataset, Recording, Uncertainty
from fe_models.simulation import FreeConfig, simulate_free
from hybrid.diagnosis.contest.setting import setting_of
from hybrid.diagnosis.series_diagnosis import diagnose_series as diagnose

PAGE = Path(__file__).parents[1] / "docs" / "add_a_cause.md"
PLACE = {"node": 3, "direction": "x"}
STIFFNESS = 0.02  # N/m^5: at 2 m, which the chain reaches, 0.64 N beside the 7 N of the springs there
NOISE = 0.02  # of each channel's rms


@pytest.fixture
def quintic_spring(tmp_path: Path) -> Iterator[Any]:
    """The class in the page's file, known as long as a test runs."""
    (code,) = re.findall(r"```python\n(.*?)```", PAGE.read_text(), flags=re.DOTALL)
    path = tmp_path / "quintic_spring.py"
    path.write_text(code)
    spec = importlib.util.spec_from_file_location("quintic_spring", path)
    assert spec is not None
    assert spec.loader is not None
    module = sys.modules["quintic_spring"] = importlib.util.module_from_spec(spec)
    try:
        spec.loader.exec_module(module)
        yield module.QuinticSpring
    finally:
        CAUSES.pop("quintic_spring", None)
        del sys.modules["quintic_spring"]


def recorded(cause: Any) -> Dataset:
    """Free vibrations of the chain with a cause in it, simulated in steps finer than the diagnosis' own."""
    rng, design = np.random.default_rng(5), four_dof()
    start = rng.standard_normal((2, 5, 4))  # m and m/s
    motion = simulate_free(design.with_effects(cause), start[0], start[1], FreeConfig(30.0, 10.0, 0.02), progress=False)
    data = np.stack([motion.shown(s) for s in SENSORS], axis=-1)
    data = data + NOISE * data.std(axis=(0, 1)) * rng.standard_normal(data.shape)
    recordings = tuple(Recording(f"r{i}", part[None], "train" if i < 4 else "test") for i, part in enumerate(data))
    return Dataset(design, 10.0, SENSORS, recordings, assumptions=Assumptions(uncertainty=Uncertainty()))


def test_cause_of_one_file_is_found_with_its_place(quintic_spring: Any) -> None:
    dataset = recorded(quintic_spring((3,), "x", STIFFNESS))
    (finding,) = diagnose(dataset).findings
    assert isinstance(finding.cause, quintic_spring)
    assert finding.cause.location == PLACE
    stiffness = finding.parameters["stiffness"]
    assert abs(stiffness.value - STIFFNESS) < 4 * stiffness.std  # one in 16,000 would be further off by chance
    assert stiffness.std < 0.1 * STIFFNESS
    assert re.fullmatch(r"A quintic spring of [\d.e+ -]+ N/m\^5 acts at node 3 in x\.", finding.sentence)


def test_cause_is_sought_at_every_place_as_long_as_it_is_registered(quintic_spring: Any) -> None:
    setting = setting_of(recorded(quintic_spring((3,), "x", STIFFNESS)))
    places = [candidate.location for candidate in setting.candidates() if candidate.kind == "quintic_spring"]
    assert places == [candidate.location for candidate in setting.candidates() if candidate.kind == "cubic_spring"]
    assert PLACE in places
    del CAUSES[quintic_spring.kind]
    assert "quintic_spring" not in {candidate.kind for candidate in setting.candidates()}


def test_files_have_it_by_its_word(quintic_spring: Any, tmp_path: Path) -> None:
    structure = four_dof().with_effects(quintic_spring((3,), "x", STIFFNESS))
    save_structure(structure, tmp_path / "structure.toml")
    assert load_structure(tmp_path / "structure.toml") == structure
    del CAUSES[quintic_spring.kind]
    with pytest.raises(InputError, match="quintic_spring"):
        load_structure(tmp_path / "structure.toml")


def test_two_causes_of_one_word_are_refused() -> None:
    with pytest.raises(TypeError, match="there is a cause 'cubic_spring' already, CubicSpring"):
        type("Other", (Cause,), {"kind": CubicSpring.kind})
    assert CAUSES[CubicSpring.kind] is CubicSpring
