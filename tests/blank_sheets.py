"""Figures that are laid out and drawn by nobody, for tests that look at none: half of what results cost to write."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest


@contextmanager
def blank_sheets(*kinds: str) -> Iterator[None]:
    """Let every figure of matplotlib, curves and texts and all, be written as an empty sheet.

    ``kinds``: only as files of these, ".png" or ".svg", of which the latter are a page's; left out, as any.
    """
    from matplotlib.figure import Figure
    from matplotlib.image import imsave

    drawn = Figure.savefig

    def written(figure: Figure, path: Path, **options: Any) -> None:
        width, height = 72 * figure.get_size_inches()
        if kinds and path.suffix not in kinds:
            drawn(figure, path, **options)
        elif path.suffix == ".svg":
            path.write_text(f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width:g} {height:g}"></svg>')
        else:
            imsave(path, np.ones((1, 1, 3)))

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Figure, "savefig", written)
        yield
