"""Known forces on the modes, as smooth between samples as their splines, and what they do to the state of a step.

    z' = A z + B f(z) + F g(t),    g(t_k + s h) = sum over p of g_p s^p / p!   (0 <= s < 1)

adds sum over p of h phi_p+1(A h) F g_p to z over the step, exactly, whatever its length: g is a polynomial there
(Hochbruck & Ostermann 2010, sec. 2.1).
"""

from dataclasses import dataclass, replace
from math import factorial
from typing import cast

import torch
from torch import Tensor


@dataclass(frozen=True, eq=False)
class Driving:
    """What drives windows: loads at places, and the motion of the base.

    ``courses`` (batch, time, order, place): each force (N, N m; of a base m/s^2) and its derivatives by time in
    sampling intervals. ``participation`` (place, mode): q'' a unit of it. ``shown`` (batch, time, sensor): what sensors
    show at once, whatever the state: accelerations by the forces, the base's own motion.
    """

    courses: Tensor
    participation: Tensor
    shown: Tensor

    def __getitem__(self, windows: Tensor | slice) -> "Driving":
        """Return that of some windows."""
        return replace(self, courses=self.courses[windows], shown=self.shown[windows])

    def first(self, samples: int) -> "Driving":
        """Return that of the first ``samples``."""
        return self.part(0, samples)

    def part(self, begin: int, end: int) -> "Driving":
        """Return that of the samples from ``begin`` to before ``end``."""
        return replace(self, courses=self.courses[:, begin:end], shown=self.shown[:, begin:end])

    def of_sensors(self, columns: list[int]) -> "Driving":
        """Return it with what some of the sensors show."""
        return replace(self, shown=self.shown[..., columns])

    def repeated(self, count: int) -> "Driving":
        """Return that of all windows ``count`` times, one time after the other."""
        return replace(self, courses=self.courses.repeat(count, 1, 1, 1), shown=self.shown.repeat(count, 1, 1))

    def to(self, like: Tensor) -> "Driving":
        """Return it as numbers of the type, and on the device, of another tensor."""
        return Driving(self.courses.to(like), self.participation.to(like), self.shown.to(like))

    def split(self, windows: int) -> "list[Driving]":
        """Return so many ``windows`` after the other."""
        return [self[slice(begin, begin + windows)] for begin in range(0, len(self.courses), windows)]

    @property
    def acceleration(self) -> Tensor:
        """What the forces add to q'' at the samples, (batch, time, mode)."""
        return self.courses[:, :, 0] @ self.participation

    def at(self, time: Tensor) -> Tensor:
        """Return what the forces add to q'' at one ``time`` in sampling intervals, (batch, mode)."""
        sample = int(time.detach().clamp(0, self.courses.shape[1] - 1))
        orders = torch.arange(self.courses.shape[2], dtype=self.courses.dtype, device=self.courses.device)
        weights = (time - sample).to(self.courses) ** orders / torch.exp(torch.lgamma(orders + 1))
        return torch.einsum("o,bop->bp", weights, self.courses[:, sample]) @ self.participation

    def pushes(self, A: Tensor, feed: Tensor, step: float, substeps: int = 1) -> Tensor:
        """Return what the forces add to z over each substep, (batch, substep, state).

        ``A`` (state, state), ``feed`` F (state, place), ``step`` (s) between samples.
        """
        weights = _push_weights(A, feed, self.courses.shape[2], step / substeps)  # (order, place, state)
        known = self.courses[:, :-1].flatten(2)  # (batch, step, order * place)
        parts = [
            known @ torch.einsum("oq,qps->ops", _later(self.courses, part, substeps), weights).flatten(0, 1)
            for part in range(substeps)
        ]
        return torch.stack(parts, dim=2).flatten(1, 2)


def parts_of(driving: Driving | None, windows: int, count: int) -> list[Driving | None]:
    """Return what drives ``count`` windows, so many ``windows`` after the other; None of each where nothing does."""
    if driving is None:
        return [None] * -(-count // windows)
    return cast("list[Driving | None]", driving.split(windows))


def _later(courses: Tensor, part: int, substeps: int) -> Tensor:
    """Return S (order, order): the derivatives at a substep, by time in substeps, are those at the sample times S."""
    orders, s = courses.shape[2], part / substeps
    S = [
        [s ** (i - j) / factorial(i - j) / substeps**j if i >= j else 0.0 for j in range(orders)] for i in range(orders)
    ]
    return torch.tensor(S, dtype=courses.dtype, device=courses.device)


def _push_weights(A: Tensor, feed: Tensor, orders: int, step: float) -> Tensor:
    """Return h phi_p+1(A h) F transposed, (order, place, state), all from one matrix exponential.

    exp of [[A h, F h, 0, ...], [0, 0, I, 0, ...], ...] has them in its first rows (Al-Mohy & Higham 2011, theorem 2.1).
    """
    states, places = feed.shape
    rows = [torch.cat([A * step, feed * step, A.new_zeros(states, (orders - 1) * places)], dim=1)]
    chain = torch.eye(orders * places, dtype=A.dtype, device=A.device)
    rows.append(torch.cat([A.new_zeros(orders * places, states + places), chain[:, : (orders - 1) * places]], dim=1))
    blocks = torch.matrix_exp(torch.cat(rows))[:states, states:]  # (state, order * place)
    return blocks.unflatten(1, (orders, places)).permute(1, 2, 0)
