"""The same recording in every format that is read: alike to the last digit of that format, or refused clearly."""

import io
import struct
import subprocess
import sys
import warnings
import zipfile
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
import pyuff
from nptdms import ChannelObject, TdmsWriter
from scipy.io import savemat

from fe_models.arrays import FloatArray
from fe_models.errors import InputError
from fe_models.files import matlab_files, size_limit
from fe_models.files.array_files import load_arrays
from fe_models.files.dataset_file import load_dataset
from fe_models.recordings import Dataset
from tests.sample_dataset import NAMES, RATE, SAMPLES, TOML, assert_fault, free_decay, write_sample

DATA = free_decay(1)
G = 9.80665  # m/s^2
Write = Callable[[Path, FloatArray], None]


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return write_sample(tmp_path)


def text_of(file: str, key: str | None = None) -> str:
    return TOML.replace('"r1.npz"\nkey = "data"', f'"{file}"' + (f'\nkey = "{key}"' if key else ""))


def loaded(folder: Path, file: str, key: str | None = None) -> Dataset:
    """The sample dataset, its first recording read from a file of another format."""
    (folder / "dataset.toml").write_text(text_of(file, key))
    return load_dataset(folder / "dataset.toml")


def faults_with(folder: Path, file: str, key: str | None = None) -> tuple[str, ...]:
    with pytest.raises(InputError) as caught:
        loaded(folder, file, key)
    return caught.value.faults


def write_mat_73(path: Path, arrays: dict[str, Any]) -> None:
    """As MATLAB does: HDF5 behind a block of its own, arrays turned, with their class."""
    with h5py.File(path, "w", userblock_size=512) as file:
        for name, array in arrays.items():
            item = file.create_dataset(name, data=np.asarray(array).T, compression="gzip", chunks=True)
            item.attrs["MATLAB_class"] = np.bytes_(b"double")
    with path.open("r+b") as file:
        file.write(b"MATLAB 7.3 MAT-file, written by a test".ljust(116) + b"\0" * 8 + b"\x00\x02IM")


def write_uff(path: Path, data: FloatArray, binary: int = 0, rate: float = RATE, named: str = "id1") -> None:
    """A data set a channel, in an order of its own, behind an impulse response that is no time history."""
    file = pyuff.UFF(str(path))
    frf = pyuff.prepare_58(binary=0, func_type=4, rsp_node=1, rsp_dir=1, ref_node=1, ref_dir=1,
                           data=np.ones(8) + 0j, x=np.arange(8.0), id1="a frequency response",
                           orddenom_spec_data_type=13)  # fmt: skip
    file.write_sets(frf, mode="overwrite")
    for place in (2, 0, 1):
        words = {named: NAMES[place]} if named else {}
        history = pyuff.prepare_58(
            binary=binary,
            func_type=1,
            rsp_node=place + 2,
            rsp_dir=(1, 1, -2)[place],
            ref_node=0,
            ref_dir=0,
            data=data[:, place],
            x=np.arange(len(data)) / rate,
            abscissa_spacing=1,
            abscissa_inc=1 / rate,
            abscissa_min=0.0,
            orddenom_spec_data_type=0,
            ordinate_axis_units_lab=("m/s^2", "g", "NONE")[place],
            **words,
        )
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ResourceWarning)  # pyuff's writer leaves files open
            file.write_sets(history)


def write_tdms(path: Path, data: FloatArray, rate: float = RATE, unit: str = "m/s^2") -> None:
    with TdmsWriter(path) as file:
        waveform = {"wf_increment": 1 / rate, "wf_start_offset": 0.0}
        units = (unit, unit, None)
        columns = [
            ChannelObject("logger", name, column, waveform | ({"unit_string": own} if own else {}))
            for name, column, own in zip(NAMES, data.T, units, strict=True)
        ]
        file.write_segment([*columns[::-1], ChannelObject("logger", "words", np.array(["a", "b"]))])


def in_g(data: FloatArray) -> FloatArray:
    """The data with channel a3 in g."""
    return data / np.array([1.0, G, 1.0])


@pytest.mark.parametrize("order", ["C", "F"])
def test_npy(folder: Path, order: Any) -> None:
    np.save(folder / "r1.npy", np.array(DATA, order=order))
    np.testing.assert_array_equal(loaded(folder, "r1.npy").recordings[0].data[0], DATA)


@pytest.mark.parametrize("compressed", [False, True])
@pytest.mark.parametrize("version", ["4", "5", "7.3"])
def test_mat_of_each_version(folder: Path, version: str, compressed: bool) -> None:
    if version == "7.3":
        write_mat_73(folder / "r1.mat", {"acc": DATA})
    else:
        savemat(folder / "r1.mat", {"acc": DATA}, format=version, do_compression=compressed and version == "5")
    np.testing.assert_array_equal(loaded(folder, "r1.mat", "acc").recordings[0].data[0], DATA)


@pytest.mark.parametrize("suffix", ["mat", "npz"])
def test_arrays_of_one_channel_each_are_taken_by_the_sensors_names(folder: Path, suffix: str) -> None:
    arrays = {**dict(zip(NAMES, DATA.T, strict=True)), "other": np.ones(7), "dt": 1 / RATE}
    np.savez(folder / "r1.npz", **arrays) if suffix == "npz" else savemat(folder / "r1.mat", arrays)
    np.testing.assert_array_equal(loaded(folder, f"r1.{suffix}").recordings[0].data[0], DATA)
    savemat(folder / "r1.mat", arrays | {"dt": 0.02})
    assert_fault(faults_with(folder, "r1.mat"), "its time step is 0.02 s (50 Hz), but sampling_rate says 100 Hz")


@pytest.mark.parametrize("binary", [0, 1])
@pytest.mark.parametrize("named", ["id1", "rsp_ent_name"])
def test_a_universal_file_s_channels_are_taken_by_name_in_the_units_that_it_states(
    folder: Path, binary: int, named: str
) -> None:
    write_uff(folder / "r1.uff", in_g(DATA), binary, named=named)
    dataset = loaded(folder, "r1.uff")
    np.testing.assert_allclose(dataset.recordings[0].data[0], DATA, rtol=1e-10, atol=1e-12)  # twelve digits of text
    assert "r1.uff: a3: converted from g, which the file states, to m/s^2" in dataset.notes


def test_an_unnamed_channel_of_a_universal_file_has_the_name_of_its_place(folder: Path) -> None:
    write_uff(folder / "r1.uff", DATA, named="")
    assert_fault(faults_with(folder, "r1.uff"), "no column for sensor 'a2'; it has '4:-y', '2:x', '3:x'")


def test_the_rate_of_a_universal_file_is_held_against_the_dataset_s(folder: Path) -> None:
    write_uff(folder / "r1.uff", DATA, rate=200.0)
    assert_fault(faults_with(folder, "r1.uff"), "its time step is 0.005 s (200 Hz), but sampling_rate says 100 Hz")


def test_tdms_channels_are_taken_by_name_in_the_units_that_they_state(folder: Path) -> None:
    write_tdms(folder / "r1.tdms", DATA / np.array([G, G, 1.0]), unit="g")
    dataset = loaded(folder, "r1.tdms")
    np.testing.assert_allclose(dataset.recordings[0].data[0], DATA, rtol=1e-14)
    assert "r1.tdms: a2, a3: converted from g, which the file states, to m/s^2" in dataset.notes
    write_tdms(folder / "r1.tdms", DATA, rate=50.0)
    assert_fault(faults_with(folder, "r1.tdms"), "its time step is 0.02 s (50 Hz), but sampling_rate says 100 Hz")
    write_tdms(folder / "r1.tdms", DATA, unit="mm")
    assert_fault(faults_with(folder, "r1.tdms"), "column 'a2' is in mm, which is no m/s^2")


@pytest.mark.parametrize("kept", [0.2, 0.6, 0.95])
@pytest.mark.parametrize("suffix", ["uff", "58b.uff", "tdms", "7.3.mat", "npy"])
def test_a_truncated_file_is_bad_input(folder: Path, suffix: str, kept: float) -> None:
    path = folder / f"r1.{suffix}"
    if suffix.endswith("uff"):
        write_uff(path, DATA, int("58b" in suffix))
    elif suffix == "tdms":
        write_tdms(path, DATA)
    elif suffix == "npy":
        np.save(path, DATA)
    else:
        write_mat_73(path, {"data": DATA})
    whole = path.read_bytes()
    path.write_bytes(whole[: int(kept * len(whole))])
    assert_fault(faults_with(folder, path.name), path.name)


@pytest.mark.parametrize("suffix", ["uff", "tdms", "npy", "txt"])
@pytest.mark.parametrize(
    "content", [b"", b"    -1\n    58\n    -1\n", b"TDSm\x0e\0\0\0\xff", b"\x93NUMPY\x01\0v\0{'descr'"]
)
def test_a_file_of_another_kind_is_bad_input(folder: Path, suffix: str, content: bytes) -> None:
    (folder / f"r1.{suffix}").write_bytes(content)
    assert_fault(faults_with(folder, f"r1.{suffix}"), f"r1.{suffix}")


class Malicious:
    """Unpickling an instance would make a file."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def __reduce__(self) -> tuple[Any, ...]:
        return Path.touch, (self.path,)


@pytest.mark.parametrize("save", [np.save, np.savez])
def test_a_pickle_is_refused_and_not_run(folder: Path, save: Any) -> None:
    suffix = "npy" if save is np.save else "npz"
    save(folder / f"r1.{suffix}", np.array([Malicious(folder / "ran")], dtype=object), allow_pickle=True)
    assert_fault(faults_with(folder, f"r1.{suffix}"), "is an array of Python objects (a pickle, which may run code)")
    assert not (folder / "ran").exists()


def test_matlab_s_structs_and_cells_are_named_and_not_read(folder: Path) -> None:
    savemat(folder / "r1.mat", {"model": {"a": 1}, "parts": np.array([1, "x"], dtype=object), "word": "text"})
    assert_fault(faults_with(folder, "r1.mat"), "'model' is a MATLAB struct, which is not read")
    savemat(folder / "r1.mat", {"model": {"a": 1}, "acc": DATA})
    assert_fault(faults_with(folder, "r1.mat", "model"), "no plain array 'model': it is a MATLAB struct")
    with h5py.File(folder / "r1.mat", "w") as file:
        file.create_group("model")
        file["elsewhere"] = h5py.ExternalLink("r2.mat", "/data")
        file.create_dataset("far", data=None, shape=(4,), dtype=float, external=[("r1.npz", 0, 32)])
    faults = faults_with(folder, "r1.mat")
    for words in ("'model' is a MATLAB struct", "'elsewhere' is a link", "'far' is data that stand in another file"):
        assert_fault(faults, words)


def claiming_header(shape: tuple[int, ...]) -> bytes:
    """An .npy file's beginning for an array of that shape, without the array."""
    file = io.BytesIO()
    np.lib.format.write_array_header_1_0(file, {"descr": "<f8", "fortran_order": False, "shape": shape})
    return file.getvalue()


def test_a_header_that_claims_terabytes_is_refused_before_anything_is_read(folder: Path) -> None:
    claim = claiming_header((10**12, 3))
    (folder / "r1.npy").write_bytes(claim)
    with zipfile.ZipFile(folder / "r1.npz", "w") as archive:
        archive.writestr("data.npy", claim)
    with h5py.File(folder / "r1.mat", "w") as file:
        file.create_dataset("data", shape=(3, 10**12), dtype=float, chunks=(3, 1000))
    for suffix in ("npy", "npz", "mat"):
        assert_fault(faults_with(folder, f"r1.{suffix}"), "announces 3e+12 numbers, and at most 1.34e+08 are read")
    savemat(folder / "r1.mat", {"data": DATA})
    content = bytearray((folder / "r1.mat").read_bytes())
    place = content.index(struct.pack("<II", len(DATA), DATA.shape[1]))
    content[place : place + 8] = struct.pack("<II", 2**31 - 1, 2**10)
    (folder / "r1.mat").write_bytes(content)
    assert_fault(faults_with(folder, "r1.mat"), "announces 2.2e+12 numbers")


@pytest.mark.parametrize("suffix", ["uff", "b.uff", "tdms"])
def test_more_samples_announced_than_a_file_holds_are_refused(folder: Path, suffix: str) -> None:
    path = folder / f"r1.{suffix}"
    write_tdms(path, DATA) if suffix == "tdms" else write_uff(path, DATA, int("b." in suffix))
    content = path.read_bytes()
    if suffix == "tdms":
        more = content.replace(struct.pack("<Q", SAMPLES), struct.pack("<Q", 10**12))
    else:
        more = content.replace(b"%10d" % SAMPLES, b"%10d" % 10**9)
    assert more != content
    path.write_bytes(more)
    assert_fault(faults_with(folder, path.name), path.name)


def test_what_unpacks_to_more_than_the_limit_is_refused_without_being_kept(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A megabyte of zeros stands for terabytes: small where packed, and beyond a limit of a tenth of it."""
    zeros = np.zeros((2**15, 4))
    np.savez_compressed(folder / "r1.npz", data=zeros)
    savemat(folder / "r1.mat", {"data": zeros}, do_compression=True)
    assert (folder / "r1.mat").stat().st_size < zeros.nbytes / 100
    for module in (size_limit, matlab_files):
        monkeypatch.setattr(module, "MAX_BYTES", 100_000)
    for suffix in ("npz", "mat"):
        assert_fault(faults_with(folder, f"r1.{suffix}"), "GiB are read: cut it into parts")


def test_an_element_that_lies_about_its_size_is_counted_as_it_unpacks(monkeypatch: pytest.MonkeyPatch) -> None:
    bomb = zlib.compress(bytes(10**6))
    monkeypatch.setattr(size_limit, "MAX_BYTES", 10**5)
    monkeypatch.setattr(matlab_files, "MAX_BYTES", 10**5)
    file = io.BytesIO(bytes(128) + struct.pack("<II", 15, len(bomb)) + bomb)
    with pytest.raises(InputError, match="GiB are read"):
        matlab_files._check_unpacked(file, Path("bomb.mat"), "<")


def test_only_who_reads_a_format_waits_for_its_library(folder: Path) -> None:
    (folder / "r1.csv").write_text(",".join(NAMES) + "\n" + 40 * "1,2,3\n" + "2,3,4\n")
    code = (
        "import sys; from pathlib import Path; import fe_models;"
        "from fe_models.files.recording_files import load_recording;"
        f"load_recording(Path({str(folder / 'r1.csv')!r}), None, {NAMES!r}, None);"
        f"load_recording(Path({str(folder / 'r2.npz')!r}), 'data', {NAMES!r}, None);"
        "print([name for name in ('h5py', 'nptdms', 'pyuff') if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_arrays_that_are_read_may_be_written_to(tmp_path: Path) -> None:
    np.savez(tmp_path / "a.npz", data=DATA, none=np.zeros((0, 3)))
    found = load_arrays(tmp_path / "a.npz")
    found["data"][0] = 0.0
    assert found["none"].shape == (0, 3)
