"""The evidence of a claim: how probable the measured modes are if these causes, and no others, act in these recordings.

Nominal values and what any model gets wrong are marginalised in closed form about the best values, where modes are
linear in them (Laplace's approximation, exact slopes); the causes' sizes are fitted by least squares, and their prior's
share that fits (Occam's factor) is Laplace's, too. The sizes of errors are those of maximum likelihood.
"""

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from scipy.linalg import block_diag, cho_solve, solve_triangular

from fe_models.arrays import FloatArray
from hybrid.diagnosis.modal.claim import Claim
from hybrid.diagnosis.modal.config import FIT
from hybrid.diagnosis.modal.error_sizes import ErrorSizes
from hybrid.diagnosis.modal.inflation import (
    Inflation,
    likeliest_inflation,
    log_prior_in,
    without_doubts_in_frequencies,
)
from hybrid.diagnosis.modal.likely_errors import likeliest_sizes
from hybrid.diagnosis.modal.modal_data import ModalData
from hybrid.diagnosis.modal.modes_of_claim import predicted_by
from hybrid.diagnosis.modal.paired_rows import (
    log_density_of_unpaired,
    residual_of,
    rows_of,
    values_of,
)
from hybrid.diagnosis.modal.pairs import Pairs, pairs_of
from hybrid.diagnosis.modal.rows import Rows
from hybrid.diagnosis.response.hypothesis import Hypothesis


@dataclass(frozen=True, eq=False)
class Start:
    """Where a fit of a ``claim`` begins: ``theta`` (parameter,), the ``sizes`` of errors and their ``inflation``."""

    claim: Claim
    theta: FloatArray
    sizes: ErrorSizes
    inflation: Inflation = field(default_factory=dict)

    def less(self, number: int) -> "Start":
        """Return the start without one of the claim's causes."""
        kept = self.claim.hypothesis.parameters_of((number,))
        return replace(self, claim=self.claim.less(number), theta=self.theta[kept])


@dataclass(frozen=True, eq=False)
class ModalFit:
    """The best ``theta`` (parameter,) of a claim, with the ``sizes`` of errors, and the log ``evidence``.

    ``residual`` (row,), nominal values at their centre, and ``slopes`` (row, parameter); ``lower``: the Cholesky factor
    of the covariance of all ``rows``; ``covariance`` (parameter, parameter) of theta; the inverse of that with these
    sizes, ``precision``, in units of the root of theta's prior covariance, in which none is too large for another.
    """

    claim: Claim
    theta: FloatArray
    sizes: ErrorSizes
    pairs: Pairs
    rows: Rows
    residual: FloatArray
    slopes: FloatArray
    lower: FloatArray
    covariance: FloatArray
    precision: FloatArray
    evidence: float
    inflation: Inflation

    @property
    def start(self) -> Start:
        """Where a fit begins that goes on from this one."""
        return Start(self.claim, self.theta, self.sizes, self.inflation)

    @property
    def nuisances(self) -> int:
        """Number of nominal values."""
        return self.claim.hypothesis.nuisances

    @cached_property
    def white(self) -> FloatArray:
        """The residual (row,) in units of all errors."""
        return np.asarray(solve_triangular(self.lower, self.residual, lower=True))

    @property
    def weighed(self) -> FloatArray:
        """The inverse of the covariance of all rows times the residual, (row,)."""
        return np.asarray(cho_solve((self.lower, True), self.residual))


def fit_claim(
    measured: ModalData,
    start: Start,
    rounds: int = FIT.max_iterations,
    errors_too: bool = True,
    doubts_too: bool = False,
) -> ModalFit | None:
    """Return the best fit of a claim from its ``start``, None where the structure cannot stand there.

    With the sizes of errors and their inflation as they are, or, ``errors_too``, as is likeliest; or, ``doubts_too``,
    with the likeliest inflation alone, but for modes whose shapes are not known.
    """
    claim, theta, sizes, inflation = start.claim, start.theta, start.sizes, start.inflation
    hypothesis, first = claim.hypothesis, claim.hypothesis.nuisances
    best: ModalFit | None = None
    for number in range(rounds):
        predicted = predicted_by(measured, claim, theta)
        if predicted is None:
            return best
        pairs = pairs_of(measured, claim, predicted)
        known = values_of(measured, pairs)
        residual, slopes = residual_of(measured, claim, pairs, known.values, predicted)
        total = theta[:first] + measured.offset
        at_centre = residual + slopes[:, :first] @ total
        rows = rows_of(measured, claim, pairs, known.covariance, slopes[:, :first], inflation)
        try:
            if (errors_too or doubts_too) and number % 2 == 1 and len(pairs):
                sizes = likeliest_sizes(rows, at_centre, sizes, FIT.error_iterations) if errors_too else sizes
                inflation = likeliest_inflation(measured, rows, at_centre, sizes, pairs)
                if not errors_too:
                    inflation = without_doubts_in_frequencies(measured, inflation)
                rows = rows_of(measured, claim, pairs, known.covariance, slopes[:, :first], inflation)
            present = _evaluated(measured, claim, theta, sizes, pairs, rows, at_centre, slopes, inflation)
        except np.linalg.LinAlgError:  # next to nothing moves where shapes are referred to: no numbers hold that
            return best
        there = replace(present, evidence=present.evidence - _evidence_beyond(measured, present))
        best = there if best is None or there.evidence > best.evidence else best
        step = step_of(measured, present)
        then = bounded(hypothesis, theta, step)
        errors = np.sqrt(np.maximum(np.diag(present.covariance)[first:], 0.0))  # rounding may leave less than nothing
        settled = (
            np.abs(step[:first]).max(initial=0.0) < FIT.converged_log_step
            and (np.abs(step[first:]) < FIT.converged_sigma * errors).all()
        )
        theta = then
        if settled and number >= 2:
            break
    return best


def refitted_errors(measured: ModalData, item: ModalFit, claim: Claim) -> ModalFit:
    """Return a fit's theta as one of another ``claim`` with the same causes, the sizes of errors fitted anew."""
    rows = replace(item.rows, changed=np.isin(item.rows.recording, claim.changed))
    sizes = likeliest_sizes(rows, item.residual, item.sizes, FIT.error_iterations)
    return with_errors(measured, replace(item, claim=claim, rows=rows), sizes)


def with_errors(measured: ModalData, item: ModalFit, sizes: ErrorSizes) -> ModalFit:
    """Return a fit as it stands, but with other ``sizes`` of errors."""
    rows, known = item.rows, (item.residual, item.slopes, item.inflation)
    return _evaluated(measured, item.claim, item.theta, sizes, item.pairs, rows, *known)


def as_drawn(measured: ModalData, item: ModalFit) -> ModalFit:
    """Return a fit's claim and theta as those of the structure that was drawn; the rest is as it was."""
    return replace(item, claim=measured.null, theta=-measured.offset)


def _evaluated(
    measured: ModalData,
    claim: Claim,
    theta: FloatArray,
    sizes: ErrorSizes,
    pairs: Pairs,
    rows: Rows,
    residual: FloatArray,
    slopes: FloatArray,
    inflation: Inflation,
) -> ModalFit:
    """Return the fit as it stands at ``theta``; ``residual`` at the nominal values' centre."""
    hypothesis, first = claim.hypothesis, claim.hypothesis.nuisances
    known = rows.covariance_of_errors(sizes)
    lower = np.asarray(np.linalg.cholesky(rows.with_values_unknown(sizes, known)), dtype=np.float64)
    white = solve_triangular(lower, residual, lower=True)
    evidence = float(-0.5 * white @ white - np.log(np.diag(lower)).sum()) + rows.log_constant + sizes.log_prior
    width = hypothesis.width[first:]
    if len(width):
        own = solve_triangular(lower, slopes[:, first:], lower=True)
        normal = own.T @ own + np.diag(1 / width**2)
        off = (theta[first:] - hypothesis.centre[first:]) / width
        evidence += -0.5 * float(off @ off) - 0.5 * float(np.linalg.slogdet(normal)[1]) - float(np.log(width).sum())
    evidence += log_density_of_unpaired(measured, pairs) + log_prior_in(inflation, measured)
    root = block_diag(rows.prior_root(sizes), np.diag(width))
    shown = solve_triangular(np.linalg.cholesky(known), slopes, lower=True) @ root
    precision = shown.T @ shown + np.eye(len(root))
    covariance = root @ np.linalg.inv(precision) @ root.T
    about = (residual, slopes, lower, covariance, precision)
    return ModalFit(claim, theta, sizes, pairs, rows, *about, evidence, inflation)


def _evidence_beyond(measured: ModalData, item: ModalFit) -> float:
    """Return how much of the evidence is that of nominal values that the linearised modes promise, beyond these: none
    where they fit best.
    """
    first, root = item.nuisances, item.rows.prior_root(item.sizes)
    wanted = root @ (root.T @ (item.slopes[:, :first].T @ item.weighed))
    off = solve_triangular(root, wanted - measured.offset - item.theta[:first], lower=True)
    return 0.5 * float(off @ item.precision[:first, :first] @ off)


def step_of(measured: ModalData, item: ModalFit) -> FloatArray:
    """Return how far theta (parameter,) is from where the linearised modes fit best within bounds, which are approached
    by a part of the way: the others go where they fit best beside a value that is held back.
    """
    first, hypothesis = item.nuisances, item.claim.hypothesis
    width, theta = hypothesis.width[first:], item.theta[first:]
    lower, upper = hypothesis.lower[first:], hypothesis.upper[first:]
    own = solve_triangular(item.lower, item.slopes[:, first:], lower=True)
    normal = own.T @ own + np.diag(1 / width**2)
    along = own.T @ item.white - (theta - hypothesis.centre[first:]) / width**2
    step, free = np.zeros(len(width)), np.ones(len(width), dtype=bool)
    while free.any():
        step[free] = np.linalg.solve(
            normal[np.ix_(free, free)], along[free] - normal[np.ix_(free, ~free)] @ step[~free]
        )
        below, above = free & (theta + step <= lower), free & (theta + step >= upper)
        if not (below | above).any():
            break
        for bound, crossed in ((lower, below), (upper, above)):
            step[crossed] = FIT.bound_approach * (bound[crossed] - theta[crossed])
        free &= ~(below | above)
    left = item.residual - item.slopes[:, first:] @ step
    root = item.rows.prior_root(item.sizes)
    wanted = root @ (root.T @ (item.slopes[:, :first].T @ cho_solve((item.lower, True), left)))
    return np.concatenate([wanted - measured.offset - item.theta[:first], step])


def bounded(hypothesis: Hypothesis, theta: FloatArray, step: FloatArray) -> FloatArray:
    """Return theta (parameter,) after a step, cut where it would cross a bound or go too far at once."""
    first = hypothesis.nuisances
    step = step.copy()
    step[:first] = np.clip(step[:first], -FIT.max_log_step, FIT.max_log_step)
    then = theta + step
    for bound, crossed in ((hypothesis.lower, then <= hypothesis.lower), (hypothesis.upper, then >= hypothesis.upper)):
        then[crossed] = theta[crossed] + FIT.bound_approach * (bound[crossed] - theta[crossed])
    return then
