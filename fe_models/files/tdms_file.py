"""TDMS files of National Instruments' programs (LabVIEW, DIAdem, FlexLogger). nptdms reads them."""

from collections import Counter
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.errors import InputError
from fe_models.files.named_columns import NamedColumns
from fe_models.files.size_limit import check_bytes, check_values

STEP = "wf_increment"  # s, the properties of a channel that its waveform has
UNITS = ("unit_string", "NI_UnitDescription")
SAME_STEP = 1e-6  # relative


def tdms_columns(path: Path) -> NamedColumns:
    """Return the numeric channels of a TDMS file as columns, by name, or as "group/channel" where names repeat.

    `InputError` where they differ in length or rate, or the file is cut off.
    """
    from nptdms import TdmsFile  # nobody else waits for it

    check_bytes(path.stat().st_size, path)
    try:
        with path.open("rb") as content, TdmsFile.open(content) as file:  # nptdms leaves open what it cannot read
            cut_off = file.file_status.incomplete_final_segment
            channels = [each for group in file.groups() for each in group.channels() if each.dtype.kind in "iuf"]
            found = [(each.group_name, each.name, dict(each.properties), len(each)) for each in channels]
    except Exception as error:  # of a broken file nptdms raises whatever its parts do
        raise InputError(f"{path}: not a readable TDMS file ({error})") from None
    if cut_off:
        raise InputError(f"{path}: is cut off: its last segment is not whole; copy it again, or save it anew")
    if not found:
        raise InputError(f"{path}: has no channel of numbers")
    _check_alike(found, path)
    check_values(found[0][3] * len(found), path)
    repeated = Counter(name for _, name, *_ in found)
    steps = [_step(properties) for _, _, properties, _ in found if _step(properties)]
    longer = [f"{group}/{name}" for group, name, *_ in found]

    def read(columns: Sequence[int]) -> FloatArray:
        try:
            with path.open("rb") as content, TdmsFile.open(content) as file:
                chosen = [file[found[column][0]][found[column][1]] for column in columns]
                return np.stack([np.asarray(channel[:], dtype=float) for channel in chosen], axis=1)
        except Exception as error:  # as above
            raise InputError(f"{path}: not a readable TDMS file ({error})") from None

    return NamedColumns(
        path,
        tuple(name if repeated[name] == 1 else more for (_, name, *_), more in zip(found, longer, strict=True)),
        tuple(_unit(properties) for _, _, properties, _ in found),
        read,
        tuple((more,) if repeated[name] == 1 else (name,) for (_, name, *_), more in zip(found, longer, strict=True)),
        1 / steps[0] if steps else None,
    )


def _unit(properties: dict[str, object]) -> str:
    return next((str(properties[key]) for key in UNITS if properties.get(key)), "")


def _step(properties: dict[str, object]) -> float:
    """Return the time step (s) in the properties of a channel, 0 where there is none that can be one."""
    step = properties.get(STEP)
    return float(step) if isinstance(step, int | float) and 0 < step < np.inf else 0.0


def _check_alike(found: list[tuple[str, str, dict[str, object], int]], path: Path) -> None:
    _, first, properties, length = found[0]
    step = _step(properties)
    for _, name, other, samples in found:
        own = _step(other)
        if samples != length or not np.isclose(own, step, rtol=SAME_STEP):
            raise InputError(
                f"{path}: channels differ in length or rate: {first!r} has {length} samples with a step of {step:g} s,"
                f" {name!r} {samples} with {own:g} s: export those of one rate to a file of their own"
            )
