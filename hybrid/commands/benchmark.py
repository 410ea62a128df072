"""The sub-command `benchmark`, which a distribution of its own brings: see ``benchmarks/pyproject.toml``."""

from collections.abc import Callable
from importlib.metadata import entry_points

from fe_models.errors import InputError, bad_input_exits

GROUP = "hybrid_modal.commands"
"""Entry points of this group are functions that become sub-commands."""

REMEDY = "the benchmarks are not installed: in a checkout of the project, pip install ./benchmarks"


def command() -> Callable[..., None]:
    """Return the benchmark that is installed, or what tells how to get it."""
    for entry in entry_points(group=GROUP, name="benchmark"):
        return entry.load()
    return missing


def missing() -> None:
    """Measure the product against its peers. Not installed here: pip install ./benchmarks in a checkout."""
    with bad_input_exits():
        raise InputError(REMEDY)
