"""Whether the recordings show what geometry adds to linear motion, and fits of what is left when that is taken away."""

from dataclasses import replace

from hybrid.diagnosis.contest.bounds import bound_of
from hybrid.diagnosis.contest.growing import Ground, Lengths, ground_of, lengths_of
from hybrid.diagnosis.fitting.fitting import Fit, fit
from hybrid.diagnosis.fitting.geometry_response import straightened
from hybrid.diagnosis.nominal.geometry import Geometry
from hybrid.diagnosis.recorded.gauge import Gauge
from hybrid.diagnosis.recorded.records import Batch
from hybrid.diagnosis.response.side_by_side import side_by_side


def straighten(
    ground: Ground, best: Fit, lengths: Lengths, gauge: Gauge, geometries: tuple[Geometry, ...]
) -> tuple[Ground, Lengths]:
    """Return the ground, and recordings, with that geometric part which the ``best`` fit does best with: one of the
    ``geometries`` along its motion, as before, or none.

    A fit that is far off moves otherwise than the structure, and a model that a user made linear adds nothing.
    """
    trials, own = [], best.hypothesis
    for geometry in geometries:
        bent = replace(own, plant=replace(own.plant, geometry=geometry))
        straight = straightened(replace(best, hypothesis=bent), gauge)
        if straight is not None:
            trials.append(fit(bent, best.theta, straight, gauge, best.states))
    if own.plant.geometry is not None:
        plain = replace(own, plant=replace(own.plant, geometry=None))
        recorded = tuple(batch.restored for batch in best.batches)
        trials.append(fit(plain, best.theta, recorded, gauge, best.states))
    better = min((item for item in trials if item is not None), key=lambda item: item.cost, default=best)
    if better.cost >= best.cost:
        return ground, lengths
    hypothesis = replace(ground.hypothesis, plant=better.hypothesis.plant)
    cut = lengths_of(better.batches, hypothesis.states)
    again = ground_of(hypothesis, ground.whole.theta, cut, gauge, ground.short)
    return (ground, lengths) if again is None else (again, cut)


def fitted_as(ground: Fit, fits: list[Fit], gauge: Gauge) -> list[Fit]:
    """Return the fits to the same recordings as the ``ground``; what is far behind the best is left out."""
    if all(_alike(item.batches, ground.batches) for item in fits):
        return fits
    plant, bound = ground.hypothesis.plant, bound_of(fits)

    def anew(item: Fit) -> Fit | None:
        return fit(replace(item.hypothesis, plant=plant), item.theta, ground.batches, gauge, item.states)

    again = side_by_side(anew, [item for item in fits if item.charged <= bound])
    return [item for item in again if item is not None]


def _alike(batches: tuple[Batch, ...], others: tuple[Batch, ...]) -> bool:
    return all(one.data is other.data for one, other in zip(batches, others, strict=True))
