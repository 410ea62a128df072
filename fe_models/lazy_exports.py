"""Names that a package exports and imports only when they are asked for (PEP 562)."""

import sys
from collections.abc import Callable, Iterable, Mapping
from importlib import import_module


def lazy_exports(
    package: str, homes: Mapping[str, Iterable[str]]
) -> tuple[Callable[[str], object], Callable[[], list[str]]]:
    """Return the ``__getattr__`` and the ``__dir__`` of a ``package`` whose names live in other modules.

    ``homes``: the names by the module that defines them. A name is kept in the package once it was asked for.
    `AttributeError` for all other names.
    """
    home_of = {name: module for module, names in homes.items() for name in names}
    namespace = vars(sys.modules[package])

    def get(name: str) -> object:
        if name not in home_of:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        namespace[name] = found = getattr(import_module(home_of[name]), name)
        return found

    return get, lambda: sorted({*namespace, *home_of})
