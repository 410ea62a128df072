"""Which files a run reads: all that its TOML files name, in turn, whatever is wrong with them."""

from pathlib import Path

from fe_models.files.atomic import write_text
from fe_models.files.inputs import files_read


def test_every_file_that_a_dataset_names_is_read(tmp_path: Path) -> None:
    """The model, what that names in turn, recordings, loads; not what is only a word."""
    for name in ("model.toml", "K.mtx", "r1.npz", "force.npz", "x"):
        write_text(tmp_path / "data" / name, "")
    write_text(tmp_path / "modal.npz", "")
    write_text(tmp_path / "data" / "model.toml", '[matrices]\nstiffness = "K.mtx"\nmass = "M.mtx"\n')
    dataset = tmp_path / "data" / "dataset.toml"
    rows = 'recordings = [{ name = "r", file = "r1.npz", loads = [{ direction = "y", file = "force.npz" }] }]\n'
    write_text(dataset, f'model = "model.toml"\n{rows}[simulation]\nmodal_model = "../modal.npz"\n')
    names = {path.resolve().relative_to(tmp_path).as_posix() for path in files_read(dataset)}
    assert names == {"data/dataset.toml", "data/model.toml", "data/K.mtx", "data/r1.npz", "data/force.npz", "modal.npz"}


def test_files_with_faults_are_read_all_the_same(tmp_path: Path) -> None:
    write_text(tmp_path / "broken.toml", "model = ")
    write_text(tmp_path / "round.toml", f'model = "round.toml"\nname = "{"long" * 2000}"\n')
    (tmp_path / "binary.toml").write_bytes(b"\xff\xfe")
    paths = [tmp_path / name for name in ("broken.toml", "round.toml", "binary.toml", "missing.toml")]
    assert set(files_read(*paths)) == set(paths)
