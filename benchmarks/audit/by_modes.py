"""Fits by modes for the audit: cases of the chain, their claims, and the density that these are an integral of.

Integrated over are nominal values and the causes' sizes, with the modes as they depend on them; held as the fit has
them are the sizes of errors, how much larger single ones are, and which measured mode is which.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.linalg import solve_triangular

from benchmarks.audit.chain import COUNT, RATE, SENSORS, Problem, log_normal
from benchmarks.audit.nested import Target
from benchmarks.audit.ranks import DRAWS, draws_of, ranks_of
from fe_models.arrays import FloatArray
from fe_models.causes.candidate import Candidate
from hybrid.diagnosis.modal.claim import Claim
from hybrid.diagnosis.modal.error_sizes import LOG_MEDIANS, LOG_ROOT, MAX_SPREADS, SCALE_OF, ErrorSizes, sizes_at
from hybrid.diagnosis.modal.evidence import ModalFit, Start, fit_claim
from hybrid.diagnosis.modal.inflation import log_prior_in
from hybrid.diagnosis.modal.measured_modes import MeasuredModes
from hybrid.diagnosis.modal.modal_data import ModalData
from hybrid.diagnosis.modal.mode_values import FREQUENCY, RATIO, ModeValues, free_values, quantities_of, shapes_in
from hybrid.diagnosis.modal.paired_rows import log_density_of_unpaired, rows_of, values_of
from hybrid.diagnosis.modal.predicted_modes import predicted_modes
from hybrid.diagnosis.modal.rows import Rows
from hybrid.diagnosis.modal.search import ClaimSearch
from hybrid.diagnosis.modal.unsure_sizes import posterior_over_sizes
from hybrid.diagnosis.response.hypothesis import Hypothesis

RECORDINGS = ("r1", "r2")
IDENTIFIED = np.array([3e-4, 3e-4, 3e-3, 3e-3])  # errors of identification, in the order of `MODE_QUANTITIES`
STARTS = (-0.6, -0.1, 0.1, 0.6)  # prior standard deviations from doing nothing, at which a fit begins


@dataclass(frozen=True, eq=False)
class _Density:
    """The log density of a fit's measured modes and of theta, which its evidence is the integral of."""

    measured: ModalData
    item: ModalFit

    @cached_property
    def _seen(self) -> ModeValues:
        return values_of(self.measured, self.item.pairs)

    @cached_property
    def _rows(self) -> Rows:
        """All rows, with nominal values that move none of them: they are not marginalised here."""
        still = np.zeros((len(self.item.residual), self.item.nuisances))
        known = (self.measured, self.item.claim, self.item.pairs, self._seen.covariance, still)
        return rows_of(*known, self.item.inflation)

    @cached_property
    def _lower(self) -> FloatArray:
        return np.asarray(np.linalg.cholesky(self._rows.covariance(self.item.sizes)))

    @cached_property
    def _constant(self) -> float:
        """What does not depend on theta."""
        volume = float(np.log(np.diag(self._lower)).sum())
        alone = log_density_of_unpaired(self.measured, self.item.pairs)
        inflated = log_prior_in(self.item.inflation, self.measured)
        return self._rows.log_constant - volume + self.item.sizes.log_prior + alone + inflated

    @cached_property
    def prior(self) -> tuple[FloatArray, FloatArray]:
        """Centre and width (parameter,) of the prior, nominal values as uncertain as the fit says."""
        hypothesis, first = self.item.claim.hypothesis, self.item.nuisances
        scales = self.item.rows.scales(self.item.sizes)
        centre = np.concatenate([-self.measured.offset, hypothesis.centre[first:]])
        return centre, np.concatenate([scales, hypothesis.width[first:]])

    def __call__(self, theta: FloatArray) -> float | None:
        pairs = self.item.pairs
        modes = predicted_modes(self.item.claim.hypothesis, theta[None], self.measured.outputs)
        if modes is None or not modes.stands.all() or modes.roots.shape[1] <= pairs.mode.max(initial=-1):
            return None
        every = self._seen.values - modes.values_over(pairs.mode, pairs.reference)[0]
        white = solve_triangular(
            self._lower, every[free_values(pairs.reference, len(self.measured.sensors))], lower=True
        )
        return float(-0.5 * white @ white) + self._constant + log_normal(theta, *self.prior)


def case(problem: Problem, seed: int, claims: int) -> list[Target]:
    """Return the targets of a case: nothing wrong, and the best of the ``claims`` of a cause in all recordings."""
    rng = np.random.default_rng(seed)
    measured = _measured(problem, *problem.true_case(rng), ErrorSizes(), rng)
    search = ClaimSearch.of(measured, problem.candidates)
    null = fit_claim(measured, Start(measured.null, np.zeros(len(measured.nominal.spread)), ErrorSizes()))
    if null is None:
        raise RuntimeError(f"case {seed}: the chain as drawn has no modes")
    every = tuple(range(len(RECORDINGS)))
    found = [_fitted(measured, null, candidate, every) for candidate in problem.candidates]
    best = search.ranked([item for item in found if item is not None])[:claims]
    return [_target(measured, item, search.log_odds(item.claim)) for item in (null, *best)]


def ranked(problem: Problem, seed: int) -> dict[str, list[int]]:
    """Return the ranks of true values by the kind of parameter, of truth and errors that are drawn from their priors;
    none where too few modes are left of what was drawn.
    """
    rng, _, hypothesis, theta, measured = _drawn(problem, seed)
    if not measured.recordings:  # so damped that nothing vibrates
        return {}
    null = fit_claim(measured, Start(measured.null, np.zeros(len(measured.nominal.spread)), ErrorSizes()))
    item = null and _fitted(measured, null, hypothesis.candidates[0], tuple(range(len(RECORDINGS))))
    posterior = None if item is None else posterior_over_sizes(measured, item)
    return {} if item is None or posterior is None else _ranks(measured, theta, item, posterior.draws(DRAWS, rng))


def ranked_given_errors(problem: Problem, seed: int) -> dict[str, list[int]]:
    """Return the same ranks where the sizes of errors are known, and fits begin at the truth."""
    rng, sizes, hypothesis, theta, measured = _drawn(problem, seed)
    claim = Claim(hypothesis, (tuple(range(len(RECORDINGS))),))
    item = fit_claim(measured, Start(claim, theta, sizes), errors_too=False) if measured.recordings else None
    if item is None:
        return {}
    return _ranks(measured, theta, item, draws_of(item.theta, item.covariance, rng))


def _drawn(problem: Problem, seed: int) -> tuple[np.random.Generator, ErrorSizes, Hypothesis, FloatArray, ModalData]:
    """Return sizes of errors, a hypothesis and its theta from their priors, and what is measured of them."""
    rng, bare = np.random.default_rng(seed), _bare(problem)
    sizes = sizes_at(LOG_MEDIANS + LOG_ROOT @ np.clip(rng.standard_normal(len(LOG_MEDIANS)), -MAX_SPREADS, MAX_SPREADS))
    scales = np.array([getattr(sizes, SCALE_OF[kind]) for kind in bare.kinds])
    hypothesis, theta = problem.from_prior(rng, seed, scales)
    return rng, sizes, hypothesis, theta, _measured(problem, hypothesis, theta, sizes, rng)


def _ranks(measured: ModalData, theta: FloatArray, item: ModalFit, draws: FloatArray) -> dict[str, list[int]]:
    if len(item.pairs) < len(RECORDINGS) * COUNT:
        return {}
    kinds = [*measured.kinds, item.claim.hypothesis.candidates[0].kind]
    return ranks_of(kinds, theta, draws)


def _bare(problem: Problem) -> ModalData:
    return ModalData(problem.nominal, np.zeros(len(problem.nominal.spread)), SENSORS, RATE, ())


def _measured(
    problem: Problem, hypothesis: Hypothesis, theta: FloatArray, sizes: ErrorSizes, rng: np.random.Generator
) -> ModalData:
    """Return what is identified of the chain at ``theta`` in each recording: its modes with errors of these ``sizes``,
    alike in all and each one's own, and those of the identification.
    """
    bare = _bare(problem)
    modes = predicted_modes(hypothesis, theta[None], bare.outputs)
    if modes is None:
        return bare
    every = np.arange(modes.roots.shape[1])
    values = modes.values_over(every, np.argmax(np.abs(modes.shapes[0]), axis=1))[0]  # (mode, value)
    quantity = quantities_of(len(SENSORS))
    common, own, noise = sizes.common[quantity], sizes.varying[quantity], IDENTIFIED[quantity]
    fixed = np.isin(values, (0.0, 1.0))  # the entry that others are taken over has no error
    values = values + np.where(fixed, 0.0, common * rng.standard_normal(values.shape))
    found = []
    for name in RECORDINGS:
        seen = values + np.where(fixed, 0.0, own * rng.standard_normal(values.shape))
        seen = seen + noise * rng.standard_normal(values.shape)
        covariance = np.tile(np.diag(noise**2), (len(values), 1, 1))
        found.append(MeasuredModes(name, seen[:, FREQUENCY], seen[:, RATIO], shapes_in(seen), covariance))
    return replace(bare, recordings=tuple(found))


def _fitted(measured: ModalData, null: ModalFit, candidate: Candidate, acts: tuple[int, ...]) -> ModalFit | None:
    """Return the best fit with a cause, from sizes to either side of nothing."""
    claim = Claim(measured.null.hypothesis.adding(candidate), (acts,))
    starts = [candidate.neutral[0] + share * candidate.width[0] for share in STARTS]
    found = [fit_claim(measured, Start(claim, np.append(null.theta, size), ErrorSizes())) for size in starts]
    return max((item for item in found if item is not None), key=lambda item: item.evidence, default=None)


def _target(measured: ModalData, item: ModalFit, odds: float) -> Target:
    hypothesis, density = item.claim.hypothesis, _Density(measured, item)
    named = " and ".join(candidate.key for candidate in hypothesis.candidates) or "nothing"
    bounds = hypothesis.lower, hypothesis.upper
    return Target(named, density, *bounds, item.theta, item.covariance, item.evidence, odds)
