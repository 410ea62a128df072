"""What a checkpoint holds, described once, and read from a file that nobody vouches for.

The description is checked whole, and before anything is built: which parts there are, their types, the shapes of their
arrays, which depend on each other, and that all numbers are finite. Nothing in the file is executed, and no memory is
taken for arrays larger than the file itself. A digest of the content tells whether any of it has changed since it was
written.
"""

import hashlib
import pickle
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any
from zipfile import ZIP_STORED, BadZipFile, ZipFile

import torch
from pydantic import AfterValidator, BaseModel, ConfigDict, PositiveFloat, ValidationError, ValidationInfo
from torch import Tensor

from fe_models.errors import InputError
from fe_models.files.size_limit import check_bytes, require_file
from fe_models.structure import Direction

FORMAT = 5
ARCHIVE = b"PK\x03\x04"  # how a .zip file begins
REMEDY = "train again with --fresh"
READING_ERRORS = (
    pickle.UnpicklingError,
    BadZipFile,
    struct.error,
    OSError,
    RuntimeError,
    ValueError,
    TypeError,
    LookupError,
    AttributeError,
    AssertionError,
    ArithmeticError,
    EOFError,
    MemoryError,
)
"""What zipfile and torch.load raise on other files, and on those that were cut short or damaged."""
DTYPES = {"float": (torch.float32, torch.float64), "integer": (torch.int64,), "truth value": (torch.bool,)}


def _values(kind: str, *lengths: str, positive: bool = False) -> AfterValidator:
    """Return a check of a tensor: what it holds, and one name a dimension, the same length wherever a name returns."""

    def check(tensor: Tensor, info: ValidationInfo) -> Tensor:
        known: dict[str, int] = (info.context or {})["lengths"]
        _check_plain(tensor)
        if tensor.dtype not in DTYPES[kind]:
            raise ValueError(f"holds {tensor.dtype}, expected {kind}s")
        if tensor.ndim != len(lengths):
            raise ValueError(f"has shape {tuple(tensor.shape)}, expected ({', '.join(lengths)})")
        for name, length in zip(lengths, tensor.shape, strict=True):
            if known.setdefault(name, length) != length or length == 0:
                raise ValueError(f"has shape {tuple(tensor.shape)}, expected {known[name] or 'one or more'} as {name}")
        if positive and not bool((tensor > 0).all()):
            raise ValueError("holds values that are not positive")
        return tensor

    return AfterValidator(check)


def _check_plain(tensor: Tensor) -> Tensor:
    """Return the tensor; `ValueError` unless it is an ordinary one of finite numbers."""
    if type(tensor) is not Tensor or tensor.layout != torch.strided or tensor.is_quantized or tensor.requires_grad:
        raise ValueError("is no plain array of numbers")
    if not any(tensor.dtype in known for known in DTYPES.values()):
        raise ValueError(f"holds {tensor.dtype}")
    if tensor.is_floating_point() and not bool(torch.isfinite(tensor).all()):
        raise ValueError("holds values that are not finite")
    return tensor


class _Part(BaseModel):
    model_config = ConfigDict(strict=True, extra="forbid", arbitrary_types_allowed=True, allow_inf_nan=False)


class ModalPart(_Part):
    """The modal model that stays fixed: see `fe_models.linear.ModalModel`."""

    omega: Annotated[Tensor, _values("float", "mode", positive=True)]
    damping_ratio: Annotated[Tensor, _values("float", "mode")]
    shapes: Annotated[Tensor, _values("float", "degree of freedom", "mode")]
    dof_node: Annotated[Tensor, _values("integer", "degree of freedom", positive=True)]
    dof_direction: list[Direction]
    dof_free: Annotated[Tensor, _values("truth value", "degree of freedom")]


class ConnectorPart(_Part):
    """Places of a residual: see `hybrid.neural_modal_ode.connectors.Connectors`."""

    names: list[str]
    shapes: Annotated[Tensor, _values("float", "place", "mode")]
    feeds: Annotated[Tensor, _values("float", "place", "mode")]


class Content(_Part):
    """All that is in a checkpoint: ``config`` is JSON, ``structure`` a structure file, "" of matrices.

    ``sensors`` and ``history`` are rows of `Sensor` and `EpochResult`; ``model`` holds the weights, ``trainer`` where
    the training stands; ``digest`` is that of all the rest.
    """

    format: int
    config: str
    structure: str
    sensors: list[dict[str, Any]]
    modal: ModalPart
    sampling_rate: PositiveFloat
    lowpass: PositiveFloat | None
    kept: list[str]
    left_out: list[str]
    unexplained: float | None
    data_digest: str
    connectors: ConnectorPart | None
    model: dict[str, Annotated[Tensor, AfterValidator(_check_plain)]]
    trainer: dict[str, Any]
    history: list[dict[str, Any]]
    seconds: float
    digest: str


def read_content(path: Path) -> Content:
    """Return what a checkpoint holds, its tensors on the CPU; `InputError` with all that is wrong with it."""
    raw = raw_content(path)
    if isinstance(raw.get("format"), int) and raw["format"] != FORMAT:
        raise InputError(f"{path}: has checkpoint format {raw['format']}, this program reads {FORMAT}; {REMEDY}")
    if not {"config", "model", "trainer"} <= raw.keys():
        raise InputError(f"{path}: is not a checkpoint of this program (without config, model and trainer)")
    try:
        content = Content.model_validate(raw, context={"lengths": {}})
    except ValidationError as error:
        faults = [f"{'.'.join(map(str, fault['loc']))}: {_words(fault)}" for fault in error.errors(include_input=False)]
        raise damaged(path, faults) from None
    try:
        written = content_digest(raw) == content.digest
    except (TypeError, RuntimeError):  # tensors of kinds that no trainer has
        written = False
    if not written:
        raise damaged(path, ["its content is not what was written"])
    return content


def raw_content(path: Path) -> dict[str, Any]:
    """Return the content of a file unchecked: of plain containers and tensors only, whatever else is in it."""
    try:
        require_file(path)
    except InputError as error:
        remedy = "give the folder or checkpoint that 'hybrid-modal train' wrote"
        raise InputError(f"{fault}; {remedy}" for fault in error.faults) from None
    size = path.stat().st_size
    check_bytes(size, path)
    try:
        with ZipFile(path) as archive:
            if any(member.compress_type != ZIP_STORED for member in archive.infolist()):
                raise ValueError("packed")
        described = torch.load(path, map_location="meta", weights_only=True)  # sizes alone, which take no memory
        announced = sum(tensor.numel() * tensor.element_size() for tensor in tensors_of(described))
        if announced > size:
            raise InputError(f"{path}: announces {announced:.3g} bytes of numbers in {size:.3g}; {REMEDY}")
        content = torch.load(path, map_location="cpu", weights_only=True)
    except InputError:
        raise
    except READING_ERRORS as error:
        raise InputError(
            f"{path}: is not a checkpoint of this program, or damaged ({type(error).__name__}); {REMEDY}"
        ) from None
    if not isinstance(content, dict) or not all(isinstance(key, str) for key in content):
        raise InputError(f"{path}: is not a checkpoint of this program (holds a {type(content).__name__})")
    return content


def is_archive(path: Path) -> bool:
    """Return whether a file begins as those that PyTorch writes."""
    with path.open("rb") as file:
        return file.read(len(ARCHIVE)) == ARCHIVE


def damaged(path: Path, faults: list[str]) -> InputError:
    """Return the error of a checkpoint with ``faults``, which says what to do."""
    return InputError([*(f"{path}: damaged: {fault}" for fault in faults), f"{path}: {REMEDY}"])


def content_digest(content: dict[str, Any]) -> str:
    """Return the SHA-256 digest of all parts but the digest itself, types and shapes included."""
    found = hashlib.sha256()
    for piece in _pieces({key: value for key, value in content.items() if key != "digest"}):
        found.update(piece)
    return found.hexdigest()


def tensors_of(content: Any) -> Iterator[Tensor]:
    """Yield each tensor in nested containers once, however often it is referred to."""
    waiting, seen = [content], set[int]()
    while waiting:
        item = waiting.pop()
        if id(item) in seen:
            continue
        seen.add(id(item))
        if isinstance(item, Tensor):
            yield item
        elif isinstance(item, dict):
            waiting += [*item.keys(), *item.values()]
        elif isinstance(item, list | tuple | set):
            waiting += item


def _pieces(value: Any) -> Iterator[bytes]:
    if isinstance(value, Tensor):
        plain = value.detach().cpu().contiguous()
        yield f"{plain.dtype}{tuple(plain.shape)}".encode()
        yield plain.numpy().tobytes()
    elif isinstance(value, dict):
        for key in sorted(value, key=repr):
            yield f"{{{key!r}:".encode(errors="backslashreplace")
            yield from _pieces(value[key])
    elif isinstance(value, list | tuple):
        yield f"[{len(value)}".encode()
        for item in value:
            yield from _pieces(item)
    else:
        yield f"{value!r},".encode(errors="backslashreplace")


def _words(fault: Any) -> str:
    """Return a fault that pydantic found, in this program's words."""
    known = {"missing": "is missing", "extra_forbidden": "is unknown", "is_instance_of": "is no array"}
    return known.get(fault["type"], str(fault["msg"]).removeprefix("Value error, "))
