"""The laboratory recordings of the cable-stayed bridge, as its authors publish them, made into a dataset file.

Their folder holds acc_measured1.mat to acc_measured4.mat: ``acc_measured`` (time, 8) at 100 Hz, low-passed at 30 Hz,
normalised; free decay after a weight on the deck is cut loose.
"""

from pathlib import Path

from fe_models.errors import raise_faults
from fe_models.files.atomic import write_text
from fe_models.files.dataset_file import dataset_in
from fe_models.files.tables import Table
from fe_models.files.toml_text import toml_text
from fe_models.recordings import Sensor
from fe_models.structure import Direction

SAMPLING_RATE = 100.0  # Hz
LOWPASS = 30.0  # Hz
RECORDINGS = (1, 2, 3, 4)
ARRAY = "acc_measured"
PLACES: dict[str, tuple[int, Direction]] = {
    "A1": (5, "y"),  # A1..A6 sit on the deck
    "A2": (9, "y"),
    "A3": (12, "y"),
    "A4": (15, "y"),
    "A5": (18, "y"),
    "A6": (21, "y"),
    "A7": (40, "x"),  # A7 and A8 on the towers
    "A8": (53, "x"),
}


def bridge_sensors(held_out: str | None = "A2", unit: str = "1") -> tuple[Sensor, ...]:
    """Return the eight accelerometers A1..A8; the one named ``held_out`` is never fitted, only scored."""
    return tuple(
        Sensor(name, node, direction, "acceleration", unit, "held_out" if name == held_out else "measured")
        for name, (node, direction) in PLACES.items()
    )


def missing_recordings(folder: Path, without: tuple[int, ...] = ()) -> list[str]:
    """Return a fault for each of the recordings, but those that are left out, that is not in a ``folder``."""
    missing = [path for path in _files(folder, without).values() if not path.is_file()]
    return [f"{path}: no such file; the bridge's recordings are acc_measured1.mat to 4" for path in missing]


def _files(folder: Path, without: tuple[int, ...]) -> dict[int, Path]:
    return {number: folder.resolve() / f"acc_measured{number}.mat" for number in RECORDINGS if number not in without}


def write_bridge_dataset(
    folder: Path, out: Path, test: int, held_out: str | None = "A2", without: tuple[int, ...] = ()
) -> Path:
    """Write ``out``/dataset.toml on the four recordings in ``folder``: number ``test`` to score, the others to train.

    ``without``: numbers of recordings that are left out. The recordings stay where they are. Raises `InputError` with
    all that is missing or unknown, and where ``out`` holds another dataset.toml than this writes.
    """
    faults = []
    if test not in RECORDINGS or test in without:
        faults.append(f"test recording {test} does not exist; expected one of {', '.join(map(str, RECORDINGS))}")
    if held_out is not None and held_out not in PLACES:
        faults.append(f"held-out sensor {held_out!r} does not exist; expected one of {', '.join(PLACES)}")
    files = _files(folder, without)
    raise_faults(faults + missing_recordings(folder, without))
    document: Table = {
        "schema": 1,
        "model": "bridge",
        "sampling_rate": SAMPLING_RATE,
        "lowpass": LOWPASS,
        "sensors": [vars(sensor) for sensor in bridge_sensors(held_out)],
        "recordings": [
            {"name": f"r{number}", "file": path.as_posix(), "key": ARRAY, "role": "test" if number == test else "train"}
            for number, path in files.items()
        ],
    }
    results = dataset_in(out)
    results.check(files.values())
    with results.replacing() as new:
        write_text(new / "dataset.toml", toml_text(document))
    return out / "dataset.toml"
