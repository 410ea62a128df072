"""Finds places for names and numbers: none on another, nor, where that can be helped, on what is drawn."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from fe_models.arrays import BoolArray, FloatArray, IntArray

LABEL_GAP = 3.0  # px, free between two labels
CHOICES_AT_ONCE = 12  # choices that are weighed at a time: one of the first is nearly always taken
MAX_ROWS = 6  # how many rows of text a name may stand off where there is no room beside its place
# paid for lying on a label, on a point of a line, for a later choice
LABEL_COST, LINE_COST, CHOICE_COST = 1e6, 30.0, 10.0


@dataclass(frozen=True)
class Label:
    """A box of ``size`` (2,) px for a place that may move: ``at`` (frame, 2) px.

    ``choices`` (choice, 2): where its centre may stand from there, px, best first. It may lie on the points ``own`` of
    what is drawn: a number on its element.
    """

    at: FloatArray
    size: FloatArray
    choices: FloatArray
    own: tuple[int, int] = (0, 0)

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
    row = size[1] + LABEL_GAP
    far = [
        np.array([shift * size[0], way[1] * (clear + size[1] / 2 + row * step)])
        for step in range(1, MAX_ROWS)
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
    trees = [cKDTree(points) for points in lines]
    taken = np.zeros((2, len(labels), *labels[0].at.shape)) if labels else np.zeros((2, 0, 1, 2))
    for row, label in enumerate(labels):
        best, least = 0, np.inf
        for first in range(0, len(label.choices), CHOICES_AT_ONCE):
            boxes = label.boxes(label.choices[first : first + CHOICES_AT_ONCE])
            cost = _cost(boxes, taken[:, :row], lines, trees, frames, label) + CHOICE_COST * first
            if cost.min() < least:
                best, least = first + int(np.argmin(cost)), float(cost.min())
            if least <= CHOICE_COST * (first + CHOICES_AT_ONCE):  # what a later choice costs at least
                break
        chosen[row] = label.choices[best]
        taken[:, row] = label.boxes(label.choices[best : best + 1])[:, 0]
    return chosen


def _cost(
    boxes: FloatArray, taken: FloatArray, lines: FloatArray, trees: list[cKDTree], frames: IntArray, label: Label
) -> FloatArray:
    """Return what each of the boxes (2, choice, frame, 2) costs beside those ``taken`` (2, label, frame, 2)."""
    low, high = boxes[0].min(axis=0) - LABEL_GAP, boxes[1].max(axis=0) + LABEL_GAP  # (frame, 2): all that it may cover
    close = ((taken[0] < high) & (taken[1] > low)).all(axis=2).any(axis=1)
    cost = CHOICE_COST * np.arange(boxes.shape[1]) + LABEL_COST * _overlap(boxes, taken[:, close]).sum(axis=1)
    near = _within(trees, (low + high)[frames] / 2, float((high - low).max()) / 2, label.own)
    (x, y), corners = np.moveaxis(lines[:, near], 2, 0), boxes[:, :, frames, None]  # corners: (2, choice, seen, 1, 2)
    left, bottom, right, top = corners[0, ..., 0], corners[0, ..., 1], corners[1, ..., 0], corners[1, ..., 1]
    inside = (x > left) & (x < right) & (y > bottom) & (y < top)  # (choice, seen, point)
    return np.asarray(cost + LINE_COST * inside.sum(axis=(1, 2)) / len(frames))


def _within(trees: list[cKDTree], at: FloatArray, reach: float, own: tuple[int, int]) -> IntArray:
    """Return which points (near,) come within ``reach`` px of a place (seen, 2) in any frame, but the label's own."""
    found = [tree.query_ball_point(place, reach, p=np.inf) for tree, place in zip(trees, at, strict=True)]
    rows = np.unique(np.concatenate(found).astype(int))
    return np.asarray(rows[(rows < own[0]) | (rows >= own[1])])


def overlapping(labels: Sequence[Label], offsets: FloatArray) -> BoolArray:
    """Return for each label whether it lies on one before it in any frame."""
    boxes = [label.boxes(offset[None]) for label, offset in zip(labels, offsets, strict=True)]
    before = (
        np.concatenate([np.zeros((2, 0, *labels[0].at.shape)), *boxes], axis=1) if boxes else np.zeros((2, 0, 1, 2))
    )
    return np.array([_overlap(box, before[:, :row]).any() for row, box in enumerate(boxes)], dtype=bool)


def leader(at: FloatArray, low: FloatArray, high: FloatArray, near: float) -> FloatArray | None:
    """Return the line (2, 2) from a place to a box that stands more than ``near`` px off it, else None."""
    foot = np.clip(at, low, high)
    return np.stack([at, foot]) if float(np.linalg.norm(foot - at)) > near else None


def _overlap(boxes: FloatArray, others: FloatArray) -> FloatArray:
    """Return in which share of frames boxes (2, choice, frame, 2) come too near others (2, other, frame, 2)."""
    low, high = boxes[:, :, None]
    apart = (low >= others[1] + LABEL_GAP) | (others[0] >= high + LABEL_GAP)  # (choice, other, frame, 2)
    return np.asarray((~apart.any(axis=3)).mean(axis=2))
