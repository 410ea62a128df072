"""The document on the API: its examples run, and it names all that is exported."""

import json
import re
from pathlib import Path

import numpy as np
import pytest

import fe_models as fe
import hybrid
from hybrid.report.values import typeset
from tests.blank_sheets import blank_sheets

DOCUMENT = (Path(__file__).parents[1] / "docs" / "api.md").read_text(encoding="utf-8")


@blank_sheets()
def test_the_examples_run_and_find_what_was_hidden(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """One after the other, as in a notebook; the cubic spring of 0.5 N/m^3 that the data hide comes out."""
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {}
    blocks = re.findall(r"```python\n(.*?)```", DOCUMENT, flags=re.S)
    assert len(blocks) == 2
    for block in blocks:
        exec(compile(block, "docs/api.md", "exec"), names)
    report = names["report"]
    assert isinstance(report, hybrid.Report)
    (finding,) = report.findings
    assert finding.cause.location == {"node": 1, "direction": "x"}
    stiffness = finding.parameters["stiffness"]
    assert finding.cause.kind == "cubic_spring"
    assert abs(stiffness.value - 0.5) < 4 * stiffness.std  # one in 16,000 lies further off by chance
    assert any(isinstance(effect, fe.CubicSpring) for effect in report.extended.effects)
    printed = capsys.readouterr().out
    assert "cubic spring" in printed
    assert "0.03924 Hz" in printed  # the first natural mode: 0.2466 rad/s, as printed in the paper
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert page.startswith("<!DOCTYPE html>")
    assert typeset(finding.sentence).rstrip(".") in page.replace("\N{NO-BREAK SPACE}", " ")
    assert report._repr_html_().count("<table>") == 2
    saved = report.save("saved")
    assert json.loads((saved / "report.json").read_text())["verdict"] == report.verdict.value
    assert repr(report.diagnosis) == f"Diagnosis(explained: {finding!r})"
    assert repr(finding).startswith("Finding(cubic_spring at node 1 in x, probability ")
    trained = names["trained"]
    assert isinstance(trained, hybrid.TrainedModel)
    assert "hybrid" in printed and "NRMSE" in trained._repr_html_()
    again = hybrid.load_trained(trained.save(tmp_path / "model.pt"))
    assert again.scores == {}
    data, field = names["data"], names["field"]
    assert isinstance(data, fe.Dataset)
    assert isinstance(field, hybrid.PredictedField)
    same = hybrid.predict(again, data.recordings[-1].data[0], duration=10.0)
    np.testing.assert_array_equal(same.displacement, field.displacement)
    assert field.displacement.shape == field.std.shape == (101, 4)
    assert (field.std > 0).all()
    x4 = [sensor.name for sensor in field.sensors].index("x4")  # a sensor of displacement shows the field there
    np.testing.assert_allclose(field.at(4, "x")[0], field.channels[:, x4], rtol=0, atol=1e-5)  # of single precision
    np.testing.assert_allclose(field.at(4, "x")[1], field.channels_std[:, x4], rtol=1e-4)
    with pytest.raises(fe.InputError, match="has no degree of freedom"):
        field.at(5, "x")
    for wrong in ({"start": 20.0}, {"duration": -1.0}, {"start": -0.1}):
        with pytest.raises(fe.InputError, match=next(iter(wrong))):
            hybrid.predict(trained, data.recordings[-1], **wrong)  # type: ignore[arg-type]
    with pytest.raises(fe.InputError, match=r"shape \(5, 3\)"):
        hybrid.predict(trained, np.zeros((5, 3)))


@pytest.mark.parametrize("package", [fe, hybrid])
def test_the_document_names_all_that_is_exported_and_nothing_else(package: object) -> None:
    name: str = package.__name__  # type: ignore[attr-defined]
    section = DOCUMENT.split(f"## `{name}`")[1].split("\n## ")[0]
    named = {word for row in re.findall(r"^\| (`.*?) \|", section, flags=re.M) for word in re.findall(r"`(\w+)`", row)}
    assert named == set(package.__all__)  # type: ignore[attr-defined]


def test_options_that_do_not_exist_are_reported() -> None:
    data = fe.simulate(fe.four_dof(), sensors=["x4"], motions=2, duration=5.0)
    with pytest.raises(fe.InputError, match="preset 'place' is unknown; did you mean 'places'") as caught:
        hybrid.train(data, "place", epoch=3)  # type: ignore[arg-type]
    assert len(caught.value.faults) == 2
    assert "did you mean 'epochs'" in caught.value.faults[1]


def test_places_take_a_node_as_files_do() -> None:
    spring = fe.CubicSpring(node=1, direction="x", stiffness=0.5)  # type: ignore[call-arg]
    assert spring == fe.CubicSpring((1,), "x", 0.5)
    assert fe.Spring(node=2, direction="x", stiffness=1.0).nodes == (2,)  # type: ignore[call-arg]
    with pytest.raises(TypeError, match="not both"):
        fe.CubicSpring(nodes=(1,), node=1, direction="x", stiffness=0.5)  # type: ignore[call-arg]


def test_recordings_are_compared_with_the_design_and_one_another(tmp_path: Path) -> None:
    """Two masses of 1 kg on springs of 200 N/m: 1.391 and 3.642 Hz, sqrt((3 -+ sqrt(5)) / 2 * 200) / (2 pi)."""
    chain = fe.Structure(
        name="two masses",
        nodes=((1.0, 0.0), (2.0, 0.0)),
        elements=(fe.Spring((1,), "x", 200.0), fe.Spring((1, 2), "x", 200.0)),
        point_masses=(fe.PointMass(1, 1.0), fe.PointMass(2, 1.0)),
        directions=("x",),
        damping=fe.Damping(modal_ratios=(0.005,)),
    )
    data = fe.simulate(chain, ["a1", "a2"], motions=2, duration=15.0, sampling_rate=50.0, noise=0.01)
    found = hybrid.compare_recordings(chain, data)
    assert all(words in repr(found) for words in ("1.391", "3.642", "motion_1", "motion_2"))
    assert found._repr_html_().startswith("<pre>")
    with blank_sheets():
        saved = found.save(tmp_path / "compared")
    assert any(saved.glob("*.json"))
    path = fe.save_dataset(data.split(0.5), str(tmp_path / "own"))
    assert [recording.role for recording in fe.load_dataset(str(path)).recordings] == ["train", "test"]
