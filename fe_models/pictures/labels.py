"""Finds places for names and numbers: none on another, nor, where that can be helped, on what is drawn."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fe_models.arrays import FloatArray, IntArray

GAP = 3.0  # px, free between two labels
ROWS = 6  # how many rows of text a name may stand off where there is no room beside its place
ON_LABEL, ON_LINE, A_STEP = (
    1e6,
    30.0,
    1.0,
)  # what is paid for lying on a label, on a point of a line, for a later choice


@dataclass(frozen=True)
class Label:
    """A box of ``size`` (2,) px for a place that may move: ``at`` (frame, 2) px.

    ``choices`` (choice, 2): where its centre may stand from there, px, best first.
    """

    at: FloatArray
    size: FloatArray
    choices: FloatArray

    def boxes(self, offsets: FloatArray) -> FloatArray:
        """Return lowest and highest corner (2, choice, frame, 2) where it stands ``offsets`` (choice, 2) off."""
        centres = self.at + offsets[:, None]
        return np.stack([centres - self.size / 2, centres + self.size / 2])


def around(size: FloatArray, clear: float, sides: str) -> FloatArray:
    """Return offsets (choice, 2) of a box of ``size`` px about a point, ``clear`` px off it, then ever farther off.

    ``sides``: "a" above, "b" below, "l" left, "r" right, the best first; the corners between them follow.
    """
    direction = {"a": (0, 1), "b": (0, -1), "l": (-1, 0), "r": (1, 0)}
    straight = [np.array(direction[side], dtype=float) for side in sides]
    corners = [a + b for i, a in enumerate(straight) for b in straight[i + 1 :] if a @ b == 0]
    near = [clear * way + size / 2 * way for way in straight]
    near += [(0.6 * clear + size / 2) * way for way in corners]
    row = size[1] + GAP
    far = [
        np.array([shift * size[0], way[1] * (clear + size[1] / 2 + row * step)])
        for step in range(1, ROWS)
        for way in straight
        if way[1]
        for shift in (0.0, 0.55, -0.55)
    ]
    far += [way * (clear + size / 2 + np.array([30.0 * step, 0.0])) for step in (1, 2) for way in straight if way[0]]
    return np.array(near + far)


def place(labels: Sequence[Label], lines: FloatArray, frames: IntArray) -> FloatArray:
    """Return the offset (label, 2) that is chosen for each, one after the other.

    ``lines`` (seen, point, 2): what is drawn in the ``frames`` (seen,). The cheapest choice is taken: far behind all
    others one that lies on a label placed before, in any frame.
    """
    chosen = np.zeros((len(labels), 2))
    taken: list[FloatArray] = []
    for row, label in enumerate(labels):
        boxes = label.boxes(label.choices)
        cost = A_STEP * np.arange(len(label.choices)) + ON_LABEL * sum(_overlap(boxes, other) for other in taken)
        low, high = boxes[:, :, frames, None]  # (choice, seen, 1, 2)
        inside = ((lines > low) & (lines < high)).all(axis=3)
        cost += ON_LINE * inside.sum(axis=(1, 2)) / len(frames)
        best = int(np.argmin(cost))
        chosen[row] = label.choices[best]
        taken.append(boxes[:, best])
    return chosen


def overlapping(labels: Sequence[Label], offsets: FloatArray) -> int:
    """Return how many pairs of labels lie on each other in any frame."""
    boxes = [label.boxes(offset[None]) for label, offset in zip(labels, offsets, strict=True)]
    return sum(int(_overlap(box, other[:, 0])[0] > 0) for row, box in enumerate(boxes) for other in boxes[:row])


def leader(at: FloatArray, low: FloatArray, high: FloatArray, near: float) -> FloatArray | None:
    """Return the line (2, 2) from a place to a box that stands more than ``near`` px off it, else None."""
    foot = np.clip(at, low, high)
    return np.stack([at, foot]) if float(np.linalg.norm(foot - at)) > near else None


def _overlap(boxes: FloatArray, other: FloatArray) -> FloatArray:
    """Return in which share of frames each of the boxes (2, choice, frame, 2) comes too near another (2, frame, 2)."""
    apart = (boxes[0] >= other[1] + GAP) | (other[0] >= boxes[1] + GAP)
    return np.asarray((~apart.any(axis=2)).mean(axis=1))
