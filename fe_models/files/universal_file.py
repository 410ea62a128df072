"""Universal files: the time histories in their data sets 58, in text or binary (58b). pyuff reads them.

The format: University of Cincinnati, Structural Dynamics Research Laboratory, "Universal File Formats", data set 58.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.errors import InputError
from fe_models.files.named_columns import NamedColumns
from fe_models.files.size_limit import check_bytes, check_values

DATA_SET = 58  # function at a nodal degree of freedom
TIME_RESPONSE = 1  # of its kinds of functions
DELIMITER = b"    -1"  # stands before and behind each data set
DIRECTIONS = {1: "x", 2: "y", 3: "z", 4: "rx", 5: "ry", 6: "rz"}  # with a minus sign where they point the other way
NO_NAME = ("", "NONE")
SAME_STEP = 1e-6  # relative: steps are written with six digits

Header = dict[str, Any]


def universal_columns(path: Path) -> NamedColumns:
    """Return the time histories of a universal file as columns; `InputError` where it has none or is cut off.

    A column is found by its first line of identification, its response entity, or its place, as "12:y".
    """
    import pyuff  # nobody else waits for it

    check_bytes(path.stat().st_size, path)
    _check_ends(path)
    try:
        file = pyuff.UFF(str(path))
        kinds = file.get_set_types()
        headers = {n: file.read_sets(n, header_only=True) for n in range(len(kinds)) if int(kinds[n]) == DATA_SET}
    except Exception as error:  # pyuff raises no narrower kind
        raise InputError(f"{path}: not a readable universal file ({error})") from None
    histories = {n: header for n, header in headers.items() if header["func_type"] == TIME_RESPONSE}
    if not histories:
        raise InputError(f"{path}: has no time history (data set 58, function type 1); it has {_listed(kinds)}")
    first = next(iter(histories.values()))
    for header in histories.values():
        _check_alike(header, first, path)
    check_values(int(first["num_pts"]) * len(histories), path)
    numbers, spoken = list(histories), [_names(header) for header in histories.values()]
    which = next(kind for kind in range(len(spoken[0])) if _tells_apart([names[kind] for names in spoken]))

    def read(columns: Sequence[int]) -> FloatArray:
        return np.stack([_values(file, numbers[column], histories, path) for column in columns], axis=1)

    return NamedColumns(
        path,
        tuple(names[which] for names in spoken),
        tuple(str(header["ordinate_axis_units_lab"]).strip().replace("NONE", "") for header in histories.values()),
        read,
        tuple(names[:which] + names[which + 1 :] for names in spoken),
        1 / float(first["abscissa_inc"]),
    )


def _check_ends(path: Path) -> None:
    """Raise `InputError` unless the last data set has its end: without it pyuff leaves that set out silently."""
    with path.open("rb") as file:
        file.seek(max(0, path.stat().st_size - 4096))
        tail = file.read().rstrip()
    if not tail:
        raise InputError(f"{path}: is empty")
    if not tail.endswith(DELIMITER):
        raise InputError(f"{path}: is cut off: its last data set has no end; copy it again, or export it anew")


def _check_alike(header: Header, first: Header, path: Path) -> None:
    name = _names(header)[0]
    if header["ord_data_type"] in (5, 6):
        raise InputError(f"{path}: channel {name!r} holds complex values, which no time history has")
    if header["abscissa_spacing"] != 1 or not header["abscissa_inc"] > 0:
        raise InputError(f"{path}: channel {name!r} is not sampled at a constant rate: resample it")
    if header["num_pts"] != first["num_pts"] or not np.isclose(
        header["abscissa_inc"], first["abscissa_inc"], rtol=SAME_STEP
    ):
        raise InputError(
            f"{path}: channels differ in length or rate: {_names(first)[0]!r} has {first['num_pts']} samples at"
            f" {1 / first['abscissa_inc']:g} Hz, {name!r} {header['num_pts']} at {1 / header['abscissa_inc']:g} Hz"
        )


def _names(header: Header) -> tuple[str, ...]:
    """Return what a channel may be called, the likeliest first; unnamed ones have "" there."""
    place = header["rsp_dir"]
    direction = DIRECTIONS.get(abs(place), str(place))
    words = (str(header[key]).strip() for key in ("rsp_ent_name", "id1"))
    return (
        *("" if word in NO_NAME else word for word in words),
        f"{header['rsp_node']}:{'-' * (place < 0)}{direction}",
    )


def _tells_apart(names: list[str]) -> bool:
    """Whether names are all there and no two alike; those of places, the last resort, always are the names."""
    return all(names) and (len(set(names)) == len(names) or ":" in names[0])


def _values(file: Any, number: int, histories: dict[int, Header], path: Path) -> FloatArray:
    """Return the values (sample,) of a channel, in the unit that is written beside them."""
    header = histories[number]
    try:
        values = np.asarray(file.read_sets(number)["data"], dtype=float)
    except Exception as error:  # pyuff raises no narrower kind
        raise InputError(f"{path}: channel {_names(header)[0]!r} cannot be read ({error})") from None
    if len(values) < header["num_pts"]:
        raise InputError(
            f"{path}: channel {_names(header)[0]!r} has {len(values)} values where {header['num_pts']} are announced:"
            " copy the file again, or export it anew"
        )
    return values[: header["num_pts"]]  # some programs fill the last line up


def _listed(kinds: Sequence[int]) -> str:
    return ", ".join(f"data set {kind}" for kind in sorted({int(kind) for kind in kinds})) or "no data set at all"
