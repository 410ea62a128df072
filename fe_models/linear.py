"""The linear model M u'' + C u' + K u = f over the free degrees of freedom, and its natural modes, as plain data.

Matrices that another program assembled may name groups of elements with their shares: K is the sum of the groups'
shares and of what never changes, and so is M.
"""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array

from fe_models.arrays import FloatArray, IntArray
from fe_models.dof_map import DofMap
from fe_models.html import html_table


@dataclass(frozen=True, repr=False)
class MatrixGroup:
    """A named group of elements and its shares of ``mass`` and ``stiffness``, sparse (free, free), zero where none."""

    name: str
    mass: csr_array
    stiffness: csr_array

    def __repr__(self) -> str:
        return f"MatrixGroup({self.name!r})"


@dataclass(frozen=True, repr=False)
class LinearModel:
    """Sparse matrices over the free degrees of freedom, and where these sit.

    ``mass`` (kg), ``damping`` (N s/m), ``stiffness`` (N/m): (free, free). ``coordinates``: (node, 2), in space
    (node, 3), in m of all nodes, those of the structure first, then those that refinement added. ``modal_ratios``:
    damping ratios of the first modes that come on top of ``damping``, the last number going on for all higher modes;
    ``replaced_ratios``: (mode, ratio) of those whose damping ratio is ``ratio`` whatever ``damping`` and
    ``modal_ratios`` give them. As matrices they would be full. Of imported matrices: the shares of named ``groups`` of
    elements, and ``lines`` (line, 2), numbers of the nodes between which a picture draws a line, None where it is left
    to the picture.
    """

    mass: csr_array
    damping: csr_array
    stiffness: csr_array
    dofs: DofMap
    coordinates: FloatArray
    modal_ratios: tuple[float, ...] = ()
    replaced_ratios: tuple[tuple[int, float], ...] = ()
    groups: tuple[MatrixGroup, ...] = ()
    lines: IntArray | None = None

    def __repr__(self) -> str:
        groups = f", groups {', '.join(group.name for group in self.groups)}" if self.groups else ""
        return f"LinearModel({self.mass.shape[0]} free degrees of freedom, {len(self.coordinates)} nodes{groups})"

    @property
    def has_modal_damping(self) -> bool:
        """Whether ``damping`` is not all of it."""
        return any(self.modal_ratios) or bool(self.replaced_ratios)


@dataclass(frozen=True, repr=False)
class ModalModel:
    """Natural modes: ``omega`` (mode,) rad/s, ``damping_ratio`` (mode,), ``shapes`` (dof, mode).

    The shapes, over all degrees of freedom, are mass-normalised, Phi^T M Phi = I, and zero at the supports.
    """

    omega: FloatArray
    damping_ratio: FloatArray
    shapes: FloatArray
    dofs: DofMap

    def __repr__(self) -> str:
        head = f"{'mode':>4s} {'frequency':>12s} {'damping ratio':>15s}"
        rows = [f"{mode:>4s} {frequency:>12s} {ratio:>15s}" for mode, frequency, ratio in self._rows()]
        return "\n".join([head, *rows])

    def _repr_html_(self) -> str:
        return html_table(("mode", "frequency", "damping ratio"), self._rows())

    def _rows(self) -> list[tuple[str, str, str]]:
        pairs = zip(self.frequencies, self.damping_ratio, strict=True)
        return [(str(mode), f"{f:.4g} Hz", f"{100 * xi:z.3g} %") for mode, (f, xi) in enumerate(pairs, start=1)]

    @property
    def frequencies(self) -> FloatArray:
        """Natural frequencies (Hz), shape (mode,)."""
        return self.omega / (2 * np.pi)
