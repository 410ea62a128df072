"""Eigensystem realisation: a linear state-space model identified from free decays alone, a peer of the hybrid model.

    x_k+1 = A x_k,   y_k = C x_k,   with   A = S^-1/2 U^T H1 V S^-1/2   and C the first block row of U S^1/2,

where H0 = U S V^T is the block Hankel matrix of the recordings, cut at the order, and H1 the same one sample later
(Juang & Pappa, J. Guidance 8(5), 1985). It knows neither a structure nor where its sensors sit: every channel that it
forecasts has to be among those it was identified from.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.errors import InputError
from hybrid.identification.config import REALISATION


@dataclass(frozen=True)
class StateSpace:
    """``transition`` A (state, state) from one sample to the next and ``output`` C (channel, state)."""

    transition: FloatArray
    output: FloatArray

    def observability(self, samples: int) -> FloatArray:
        """Return C A^k for each sample k, (time, channel, state)."""
        rows = [self.output]
        for _ in range(samples - 1):
            rows.append(rows[-1] @ self.transition)
        return np.array(rows)


def realise(
    recordings: Sequence[FloatArray],
    order: int = REALISATION.order,
    rows: int = REALISATION.block_rows,
    spacing: int = 1,
    stride: int = 1,
) -> StateSpace:
    """Return the model of free decays (realisation, time, channel), a column for every ``stride``-th sample.

    The block rows lie ``spacing`` samples apart, so that few of them span slow modes; H1 is one sample later all the
    same.
    """
    before, after = zip(*(_hankel_pair(recording, rows, spacing, stride) for recording in recordings), strict=True)
    U, S, Vt = np.linalg.svd(np.hstack(before), full_matrices=False)
    if order > len(S):
        raise InputError(
            f"{len(S)} states at most can be estimated from {rows} block rows of these recordings, not {order}"
        )
    root = np.sqrt(np.maximum(S[:order], np.finfo(float).eps * S[0]))  # of exact data many states hold nothing
    transition = (U[:, :order] / root).T @ np.hstack(after) @ (Vt[:order].T / root)
    return StateSpace(transition, U[: recordings[0].shape[2], :order] * root)


def forecast_from_start(model: StateSpace, windows: FloatArray, samples: int) -> FloatArray:
    """Forecast windows (window, time, channel) whole, from the state that fits their first ``samples`` best."""
    seen = model.observability(windows.shape[1])  # (time, channel, state)
    first = windows[:, :samples].reshape(len(windows), -1)
    states = np.linalg.lstsq(seen[:samples].reshape(first.shape[1], -1), first.T, rcond=None)[0]  # (state, window)
    return np.einsum("tcs,sw->wtc", seen, states)


def _hankel_pair(recording: FloatArray, rows: int, spacing: int, stride: int) -> tuple[FloatArray, FloatArray]:
    """Return H0 and H1, each (rows * channel, column), of (realisation, time, channel)."""
    lags = spacing * np.arange(rows)
    spans = np.lib.stride_tricks.sliding_window_view(recording, lags[-1] + 2, axis=1)[:, ::stride]
    columns = spans.transpose(3, 2, 0, 1)  # (row, channel, realisation, start)
    size = rows * recording.shape[2]
    return columns[lags].reshape(size, -1), columns[lags + 1].reshape(size, -1)
