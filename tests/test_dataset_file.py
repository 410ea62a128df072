"""Dataset files: round trips, and every fault named at once."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from fe_models.arrays import FloatArray
from fe_models.dofs import structure_dofs
from fe_models.errors import InputError
from fe_models.files.atomic import write_npz
from fe_models.files.dataset_file import load_dataset, save_dataset
from fe_models.files.modal_file import load_modal_model
from fe_models.linear import ModalModel
from fe_models.recordings import Assumptions, Dataset, Load, Recording, Uncertainty
from fe_models.structure import Structure
from tests.sample_dataset import (
    LOWPASS,
    MAST,
    MODAL,
    RATE,
    SAMPLES,
    SENSORS,
    assert_fault,
    broken,
    faults_of,
    free_decay,
    write_sample,
)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return write_sample(tmp_path)


def test_a_dataset_is_what_its_file_says(folder: Path) -> None:
    dataset = load_dataset(folder / "dataset.toml")
    assert dataset.model == MAST
    assert dataset.sensors == SENSORS
    assert (dataset.sampling_rate, dataset.lowpass) == (RATE, LOWPASS)
    (train,), (test,) = dataset.select("train"), dataset.select("test")
    np.testing.assert_array_equal(train.data, free_decay(1)[None])
    assert (test.loads[0].node, test.loads[0].direction, len(test.loads[0].values)) == (3, "x", SAMPLES)
    assumptions = dataset.assumptions
    assert (assumptions.damping_ratio, assumptions.modes) == ((0.01, 0.02), 2)
    assert assumptions.uncertainty == Uncertainty(stiffness=0.05)
    assert assumptions.modal_model is not None
    np.testing.assert_array_equal(assumptions.modal_model.shapes[3:], MODAL["phi"])  # given for the free rows only
    np.testing.assert_array_equal(assumptions.modal_model.shapes[:3], 0.0)
    np.testing.assert_array_equal(assumptions.modal_model.damping_ratio, [0.01, 0.01])


def sample_dataset() -> Dataset:
    load = Load(3, "x", np.linspace(0, 1, SAMPLES))
    many = np.stack([free_decay(3), free_decay(4)])
    shapes = np.vstack([np.zeros((3, 2)), MODAL["phi"]])
    modal = ModalModel(MODAL["omega"], np.array([0.01, 0.02]), shapes, structure_dofs(MAST))
    return Dataset(
        model=MAST,
        sampling_rate=RATE,
        sensors=SENSORS,
        recordings=(Recording("with/slash", free_decay(1)[None], loads=(load,)), Recording("many", many, "test")),
        lowpass=LOWPASS,
        assumptions=Assumptions(0.02, 2, modal, "newmark", 0.001, Uncertainty(0.1, 0.2, 0.3), 0.2),
    )


def test_a_saved_dataset_comes_back(tmp_path: Path) -> None:
    dataset = sample_dataset()
    again = load_dataset(save_dataset(dataset, tmp_path / "new"))
    assert (again.model, again.sensors) == (dataset.model, dataset.sensors)
    for old, new in zip(dataset.recordings, again.recordings, strict=True):
        assert (old.name, old.role) == (new.name, new.role)
        np.testing.assert_array_equal(old.data, new.data)
    np.testing.assert_array_equal(again.recordings[0].loads[0].values, dataset.recordings[0].loads[0].values)
    for name in ("damping_ratio", "modes", "integrator", "step", "uncertainty", "tolerance"):
        assert getattr(again.assumptions, name) == getattr(dataset.assumptions, name)
    assert again.assumptions.modal_model is not None
    assert dataset.assumptions.modal_model is not None
    np.testing.assert_array_equal(again.assumptions.modal_model.shapes, dataset.assumptions.modal_model.shapes)


def test_a_named_model_stays_a_name(tmp_path: Path) -> None:
    sensors = (replace(SENSORS[0], node=4),)
    recording = Recording("r", free_decay(1, channels=1)[None])
    dataset = load_dataset(save_dataset(Dataset(MAST, RATE, sensors, (recording,)), tmp_path, model_spec="four_dof"))
    assert isinstance(dataset.model, Structure)
    assert dataset.model.name == "four_dof"
    assert {path.name for path in tmp_path.glob("[!.]*")} == {"dataset.toml", "recording_1.npz"}  # no model.toml


TOML_FAULTS = [
    ("schema = 1", "schema = 2", "schema: expected 1, found 2"),
    ('"mast.toml"', '"mst.toml"', "model: "),
    ('"mast.toml"', '"brigde"', "model: model 'brigde' is unknown; did you mean 'bridge'?"),
    ("sampling_rate = 100.0\n", "", "sampling_rate: missing; expected a number"),
    ("sampling_rate = 100.0", "sampling_rate = 50.0", "a wrong sampling rate for its low-pass"),
    ("sampling_rate = 100.0", "sampling_rate = -1.0", "sampling_rate = -1 Hz; must be positive"),
    ("sampling_rate = 100.0", 'sampling_rate = "fast"', 'sampling_rate: expected a number, found "fast"'),
    ("lowpass = 30.0", "lowpass = 0", "lowpass = 0 Hz; must be positive, or left out"),
    ("lowpass = 30.0", "lowpas = 30.0", "lowpas: unknown key; did you mean 'lowpass'?"),
    ("lowpass = 30.0", "lowpass = 5.0", "of its energy lies well above the lowpass of 5 Hz"),
    ("node = 2", "node = 9", "sensors[1] (a2): node 9 does not exist; the model's nodes are 1 to 3"),
    ("node = 2", "node = 1", "sensors[1] (a2): node 1 is held in x by a support; the sensor would read zero"),
    (
        'direction = "x"',
        'direction = "u"',
        '"rx" or "ry" or "rz" or a number or [a number, ...], found "u"',
    ),
    ('"acceleration"', '"accel"', 'sensors[1].quantity: expected "displacement" or "velocity" or "acceleration"'),
    ('"m/s^2"', '"mm/s"', "sensors[1] (a2): unit 'mm/s' does not fit acceleration in x"),
    ('"m/s^2"', '"m"', "sensors[1] (a2): unit 'm' does not fit acceleration in x"),
    ('direction = "x"', 'direction = "rz"', 'does not fit acceleration in rz; expected "rad/s^2"'),
    ('name = "a3"', 'name = "a2"', "sensors: name 'a2' is used 2 times"),
    ('role = "held_out"', 'role = "hidden"', 'sensors[2].role: expected "measured" or "held_out", found "hidden"'),
    ('file = "r1.npz"', 'file = "r9.npz"', "r9.npz: no such file; the folder has modal.npz, r1.npz, r2.npz"),
    ('file = "r1.npz"', 'file = "r1.xls"', "unknown kind of file '.xls'; expected .npz, .npy, .mat, .csv"),
    ('key = "data"', 'key = "dat"', "holds no plain array 'dat'; it has data"),
    ('name = "r1"', 'name = "r2"', "recordings: name 'r2' is used 2 times"),
    ('key = "data"\n', 'key = "data"\nrole = "test"\n', 'recordings: none has the role "train"'),
    ("node = 3, direction", "node = 7, direction", "recordings[2].loads[1]: node 7 does not exist"),
    ("node = 3, direction", "node = 1, direction", "recordings[2].loads[1]: node 1 is held in x"),
    ('key = "force"', 'key = "data"', "r2.npz: shape (400, 3); expected (time,), one value a sample"),
    ("modes = 2", "modes = 0", "simulation.modes = 0; must be 1 or more"),
    ("modes = 2", "modes = 7", "simulation.modes = 7; the model has only 6"),
    ("modes = 2", "modes = 3", "2 ratios for modes = 3"),
    ("[0.01, 0.02]", "1.0", "simulation.damping_ratio: 1.0 is none; expected 0 <= ratio < 1"),
    ("[0.01, 0.02]", '"low"', "simulation.damping_ratio: expected a number or [a number, ...]"),
    ("modes = 2", 'integrator = "rk4"', 'simulation.integrator: expected "exact" or "newmark", found "rk4"'),
    ("modes = 2", "step = 0.0", "simulation.step = 0 s; must be positive"),
    ("modes = 2", "tolerance = 0", "simulation.tolerance = 0; must be positive (0.05 is 5 % of the noise floor)"),
    ("stiffness = 0.05", "stiffness = -1", "simulation.uncertainty.stiffness = -1; must not be negative"),
    ("stiffness = 0.05", "stifness = 0.05", "simulation.uncertainty.stifness: unknown key; did you mean 'stiffness'?"),
    ('"modal.npz"', '"modal2.npz"', "simulation.modal_model: "),
]


@pytest.mark.parametrize(("old", "new", "fault"), TOML_FAULTS)
def test_a_fault_of_the_file_is_named(folder: Path, old: str, new: str, fault: str) -> None:
    faults = faults_of(folder, (old, new))
    assert_fault(faults, f"dataset.toml: {fault}" if fault.startswith(("sensors", "schema")) else fault)
    assert len(set(faults)) == len(faults)


@pytest.mark.parametrize(
    ("change", "fault"),
    [
        ({"omega": np.array([3.0, -1.0])}, "omega must be positive natural frequencies"),
        ({"omega": np.array([3.0])}, "phi has shape (6, 2); expected (dof, 1)"),
        ({"phi": np.ones((5, 2))}, "phi has 5 rows; the model needs 9 rows (all degrees of freedom) or 6 (the free"),
        ({"phi": np.ones((9, 2))}, "phi is not zero at the supports of the model"),
        ({"phi": np.full((6, 2), np.nan)}, "phi holds NaN"),
        ({"xi": np.array([0.1, 0.1, 0.1])}, "xi has 3 values; expected one, or 2"),
        ({"xi": np.array([5.0])}, "xi must be damping ratios, 0 <= xi < 1"),
    ],
)
def test_a_fault_of_the_modal_model_is_named(folder: Path, change: dict[str, FloatArray], fault: str) -> None:
    write_npz(folder / "modal.npz", MODAL | change)
    assert_fault(faults_of(folder), fault)


def test_a_load_of_the_wrong_length_is_named(folder: Path) -> None:
    np.savez(folder / "r2.npz", data=free_decay(2), force=np.ones(399))
    assert_fault(faults_of(folder), "recordings[2].loads[1]: r2.npz: 399 values for 400 samples")


def test_no_sensors_and_no_recordings_are_faults(tmp_path: Path) -> None:
    (tmp_path / "d.toml").write_text('schema = 1\nmodel = "four_dof"\nsampling_rate = 10.0\n')
    with pytest.raises(InputError) as caught:
        load_dataset(tmp_path / "d.toml")
    assert_fault(caught.value.faults, "sensors: there are none")
    assert_fault(caught.value.faults, "recordings: none has the role")


def test_a_fault_of_a_table_leaves_its_other_faults_to_be_found(folder: Path) -> None:
    faults = faults_of(
        folder,
        ("node = 2", 'node = 9\ncolour = "red"'),
        ('"acceleration"', '"accel"'),
        ('file = "r1.npz"', 'file = "r9.npz"\nlength = 3'),
    )
    assert_fault(faults, "sensors[1].colour: unknown key")
    assert_fault(faults, "sensors[1].quantity: expected")
    assert_fault(faults, "sensors[1]: node 9 does not exist")
    assert_fault(faults, "recordings[1].length: unknown key")
    assert_fault(faults, "r9.npz: no such file")
    assert len(faults) == 5


def test_a_modal_model_in_the_place_of_the_model_is_reported(folder: Path) -> None:
    faults = faults_of(folder, ('"mast.toml"', '"modal.npz"'))
    assert_fault(faults, "modal.npz: holds a modal model, no matrices: name it as modal_model in [simulation] instead")
    assert len(faults) == 1


def test_all_faults_of_a_dataset_come_out_at_once(folder: Path) -> None:
    np.savez(folder / "r1.npz", data=broken(3, 0, np.inf))
    np.savez(folder / "modal.npz", omega=MODAL["omega"], xi=MODAL["xi"])
    faults = faults_of(
        folder,
        ("schema = 1", "schema = 1\ncolour = 3"),
        ("lowpass = 30.0", "lowpass = 60.0"),
        ("node = 2", "node = 99"),
        ('unit = "1"', 'unit = "inch"'),
        ('file = "r2.npz"', 'file = "gone.npz"'),
        ("modes = 2", "modes = -2"),
    )
    for words in ("colour", "low-pass", "node 99", "'inch'", "infinite", "gone.npz", "modes = -2", "phi"):
        assert_fault(faults, words)
    assert len(faults) == 9  # modes = -2 also contradicts the two damping ratios


def test_a_modal_model_over_all_dofs_is_taken_as_it_is(tmp_path: Path) -> None:
    shapes = np.vstack([np.zeros((3, 2)), MODAL["phi"]])
    write_npz(tmp_path / "m.npz", MODAL | {"phi": shapes})
    np.testing.assert_array_equal(load_modal_model(tmp_path / "m.npz", structure_dofs(MAST)).shapes, shapes)


def test_nothing_is_tested_on_what_was_trained_on(tmp_path: Path) -> None:
    """The same samples under another name would score a fit as if it were a forecast."""
    twice = (Recording("monday", free_decay(1)[None]), Recording("tuesday", free_decay(1)[None], "test"))
    path = save_dataset(replace(sample_dataset(), recordings=twice), tmp_path)
    with pytest.raises(InputError, match="'tuesday' is for testing, but holds the same samples as 'monday'"):
        load_dataset(path)


def test_an_unknown_key_hides_no_other_fault_of_the_simulation(folder: Path) -> None:
    path = folder / "dataset.toml"
    path.write_text(path.read_text().replace("[simulation]", "[simulation]\nfoo = 1\nstep = -0.5", 1))
    with pytest.raises(InputError) as caught:
        load_dataset(path)
    assert any("foo" in fault and "uncertainty" in fault for fault in caught.value.faults), caught.value.faults
    assert any("step" in fault for fault in caught.value.faults), caught.value.faults


def test_a_value_of_the_wrong_type_hides_no_other_fault_of_its_table(folder: Path) -> None:
    path = folder / "dataset.toml"
    text = path.read_text().replace("lowpass = 30.0", 'lowpass = "thirty"').replace("modes = 2", 'modes = "two"')
    text = text.replace("[simulation]", "[simulation]\nstep = -0.5", 1)
    text = text.replace("stiffness = 0.05", "stiffness = 0.05, mass = true, damping = -1")
    path.write_text(text.replace("sampling_rate = 100.0", "sampling_rate = -100.0"))
    with pytest.raises(InputError) as caught:
        load_dataset(path)
    faults = tuple(fault for fault in caught.value.faults if "recordings" not in fault)
    for words in ("thirty", "two", "step = -0.5", "mass", "damping = -1", "sampling_rate = -100"):
        assert_fault(faults, words)
