"""The hybrid model: a Neural Modal ODE learned from sparse measurements on top of a finite element model's modes.

What a notebook needs stands here (`docs/api.md`), and is loaded when it is asked for.

::

    import fe_models as fe, hybrid

    report = hybrid.diagnose(fe.four_dof(), "recordings/dataset.toml")
    print(report)
"""

from typing import TYPE_CHECKING

from fe_models.lazy_exports import lazy_exports

if TYPE_CHECKING:
    from hybrid.notebook.diagnose import diagnose as diagnose
    from hybrid.notebook.report import Report as Report

_HOMES = {
    "hybrid.notebook.diagnose": ("diagnose",),
    "hybrid.notebook.report": ("Report",),
}
__all__ = [name for names in _HOMES.values() for name in names]
if not TYPE_CHECKING:  # so that a type checker knows these names alone
    __getattr__, __dir__ = lazy_exports(__name__, _HOMES)
