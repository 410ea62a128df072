"""Whether the recordings show what geometry adds to linear motion, and fits of what is left when that is taken away."""

from dataclasses import replace

from hybrid.diagnosis.contest.bounds import bound_of
from hybrid.diagnosis.contest.growing import Lengths, ReferenceFits, lengths_of, reference_fits_of
from hybrid.diagnosis.fitting.geometry_response import straightened
from hybrid.diagnosis.fitting.least_squares import Fit, fit
from hybrid.diagnosis.nominal.geometry import Geometry
from hybrid.diagnosis.parallel import parallel_map
from hybrid.diagnosis.recorded.batches import Batch
from hybrid.diagnosis.recorded.noise_model import NoiseModel


def straighten(
    reference: ReferenceFits, best: Fit, lengths: Lengths, noise_model: NoiseModel, geometries: tuple[Geometry, ...]
) -> tuple[ReferenceFits, Lengths]:
    """Return the ground, and recordings, with that geometric part which the ``best`` fit does best with: one of the
    ``geometries`` along its motion, as before, or none.

    A fit that is far off moves otherwise than the structure, and a model that a user made linear adds nothing.
    """
    trials, own = [], best.hypothesis
    for geometry in geometries:
        bent = replace(own, nominal=replace(own.nominal, geometry=geometry))
        straight = straightened(replace(best, hypothesis=bent), noise_model)
        if straight is not None:
            trials.append(fit(bent, best.theta, straight, noise_model, best.states))
    if own.nominal.geometry is not None:
        plain = replace(own, nominal=replace(own.nominal, geometry=None))
        recorded = tuple(batch.restored for batch in best.batches)
        trials.append(fit(plain, best.theta, recorded, noise_model, best.states))
    better = min((item for item in trials if item is not None), key=lambda item: item.cost, default=best)
    if better.cost >= best.cost:
        return reference, lengths
    hypothesis = replace(reference.hypothesis, nominal=better.hypothesis.nominal)
    cut = lengths_of(better.batches, hypothesis.states)
    again = reference_fits_of(hypothesis, reference.whole.theta, cut, noise_model, reference.short)
    return (reference, lengths) if again is None else (again, cut)


def fitted_as(reference: Fit, fits: list[Fit], noise_model: NoiseModel) -> list[Fit]:
    """Return the fits to the same recordings as the ``reference``; what is far behind the best is left out."""
    if all(_alike(item.batches, reference.batches) for item in fits):
        return fits
    nominal, bound = reference.hypothesis.nominal, bound_of(fits)

    def anew(item: Fit) -> Fit | None:
        return fit(replace(item.hypothesis, nominal=nominal), item.theta, reference.batches, noise_model, item.states)

    again = parallel_map(anew, [item for item in fits if item.charged <= bound])
    return [item for item in again if item is not None]


def _alike(batches: tuple[Batch, ...], others: tuple[Batch, ...]) -> bool:
    return all(one.data is other.data for one, other in zip(batches, others, strict=True))
