"""Sparse regression on the learned residual, as SINDy does: which forces of a library make up what the model lacks.

What the nominal model lacks is learned as forces at all masses (`latent_forces`) and regressed on the candidates'
forces along the motion by PySINDy's sequentially thresholded least squares. The threshold is the one that forecasts
the forces of recordings left out; the terms that stay are named, the largest first. Of the list of causes it has words
for those that are forces: none for a sensor's faults or the simulation's time steps. It gives no probabilities.
"""

import warnings
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import eigh

from benchmarks.peers.answer import Answer
from benchmarks.peers.certain import Certain, certain_of
from benchmarks.peers.latent_forces import LatentForces, latent_forces
from fe_models.arrays import TINY, FloatArray
from fe_models.causes.candidate import Candidate, ForceCandidate, LawCandidate, MatrixCandidate, ModeCandidate
from fe_models.errors import InputError
from fe_models.recordings import Dataset
from hybrid.diagnosis.nominal.nominal_model import NominalModel
from hybrid.diagnosis.response.forces import force_of

THRESHOLDS = (0.02, 0.05, 0.1, 0.15, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8)  # of the residual's norm
RIDGE = 0.05  # PySINDy's own, for columns of norm one: forces at two places may look much alike
TOLERATED = 0.05  # of the energy of the forces left out: what a sparser choice, or none, may leave more
LEFT_OUT = 3  # every so manieth recording chooses the threshold
ENDS = 0.1  # of a recording at its start and end, where the smoother knows least
ALIKE = 1 - 1e-9  # correlation of columns that are one and the same; the first of them stands for all


@dataclass(frozen=True)
class Term:
    """The ``force`` (recording, time, coordinate) of a unit of ``name``; ``reverse``: its name where negative."""

    name: str
    force: FloatArray
    reverse: str | None = None


def name_by_regression(dataset: Dataset) -> Answer:
    """Return the causes whose forces stay in the regression, the largest first; `InputError` without PySINDy."""
    certain = certain_of(dataset)
    learned = latent_forces(certain)
    terms = as_seen(library(certain, learned), learned)
    return Answer(_named(terms, _chosen(terms, learned), learned))


def library(certain: Certain, learned: LatentForces) -> list[Term]:
    """Return the terms: the force at all masses of every candidate that is a force; linear, laws, harmonic."""
    nominal = certain.hypothesis.nominal
    M, C, K, shapes = certain.matrices
    x, v = learned.displacement, learned.velocity
    a = -(x @ K + v @ C) @ np.linalg.inv(M)  # as the nominal model has it
    terms = []
    for candidate in certain.candidates:
        name = f"{candidate.kind} {candidate.reported_location}"
        if isinstance(candidate, MatrixCandidate):
            dM, dC, dK = (shapes.T @ (change @ shapes) for change in candidate.changes)
            terms.append(Term(name, -(a @ dM + v @ dC + x @ dK)))
        elif isinstance(candidate, ModeCandidate):
            terms.append(Term(name, -v @ _modal_damping(M, K, candidate.mode)))
        elif isinstance(candidate, ForceCandidate) and candidate.kind != "slack_cable":
            pull = candidate.pull @ shapes
            if not isinstance(candidate, LawCandidate):
                terms += [Term(name, harmonic * pull) for harmonic in _harmonics(learned.force @ pull)]
            else:
                terms += [
                    Term(
                        name,
                        _law_force(nominal, candidate, start, x @ pull, v @ pull) * pull,
                        _slackness(nominal, candidate),
                    )
                    for start in candidate.first_starts
                ]
    return terms


def as_seen(terms: list[Term], learned: LatentForces) -> list[Term]:
    """Return the terms as the sensors would have shown their forces."""
    shape = learned.force.shape
    stacked = np.concatenate([np.broadcast_to(term.force, shape) for term in terms])
    seen = learned.seen(stacked).reshape(len(terms), *shape)
    return [replace(term, force=force) for term, force in zip(terms, seen, strict=True)]


def _modal_damping(M: FloatArray, K: FloatArray, mode: int) -> FloatArray:
    """Return what adds a unit of the modal damping coefficient of one mode to C (coordinate, coordinate)."""
    shape = M @ eigh(K, M)[1][:, mode]
    return np.outer(shape, shape)


def _law_force(
    nominal: NominalModel, candidate: LawCandidate, start: tuple[float, ...], u: FloatArray, rate: FloatArray
) -> FloatArray:
    """Return a law's force (recording, time, 1) along elongation and rate (recording, time)."""
    law = force_of(candidate, nominal, np.array([start]), np.ones((1, len(nominal.parts))))
    return np.asarray(-law(u.reshape(1, -1), rate.reshape(1, -1)).reshape(*u.shape, 1))


def _slackness(nominal: NominalModel, candidate: Candidate) -> str | None:
    """Return the slack cable that is a stop in compression with a negative stiffness, None where there is none."""
    if candidate.kind != "gap_stop" or candidate.location.get("side") != -1:
        return None
    nodes = candidate.location.get("nodes", [candidate.location.get("node")])
    for number, element in enumerate(nominal.structure.elements, start=1):
        if sorted(element.nodes) == sorted(nodes):
            return f"slack_cable { {'element': number} }"
    return None


def _harmonics(force: FloatArray) -> list[FloatArray]:
    """Return sine and cosine (1, time, 1) at the frequency that a force (recording, time) has most of in common."""
    samples = force.shape[1]
    spectrum = np.abs(np.fft.rfft(force.mean(axis=0) * np.hanning(samples), 8 * samples))
    turn = 2 * np.pi * int(np.argmax(spectrum)) / (8 * samples) * np.arange(samples)
    return [np.tile(harmonic(turn)[None, :, None], (len(force), 1, 1)) for harmonic in (np.sin, np.cos)]


def _chosen(terms: list[Term], learned: LatentForces) -> FloatArray:
    """Return the coefficients (term,) of the terms scaled to the residual's norm, those left out zero."""
    count, samples = learned.force.shape[:2]
    inner = slice(int(ENDS * samples), samples - int(ENDS * samples))

    def flat(force: FloatArray, kept: FloatArray) -> FloatArray:
        return np.asarray(force[kept, inner].ravel())

    held = np.arange(count) % LEFT_OUT == LEFT_OUT - 1 if count > 1 else np.zeros(count, dtype=bool)
    target = flat(learned.force, ~held)
    norms = np.array([np.linalg.norm(flat(term.force, ~held)) for term in terms])
    X = np.stack([flat(term.force, ~held) for term in terms], axis=1) / np.maximum(norms, TINY)
    own = [i for i in range(len(terms)) if norms[i] > 0 and not np.any(np.abs(X[:, :i].T @ X[:, i]) > ALIKE)]
    tested = held if held.any() else ~held
    y = flat(learned.force, tested)
    trials, losses = [np.zeros(len(terms))], [1.0]
    for threshold in THRESHOLDS:
        coefficients = np.zeros(len(terms))
        coefficients[own] = thresholded(X[:, own], target / np.linalg.norm(target), threshold)
        scaled = coefficients * np.linalg.norm(target) / np.maximum(norms, TINY)
        guess = sum((c * flat(t.force, tested) for c, t in zip(scaled, terms, strict=True) if c), np.zeros(len(y)))
        trials.append(coefficients)
        losses.append(float(np.sum((y - guess) ** 2) / np.sum(y**2)))
    good = [i for i, loss in enumerate(losses) if loss <= min(losses) + TOLERATED]
    return trials[min(good, key=lambda i: np.count_nonzero(trials[i]))]


def thresholded(columns: FloatArray, target: FloatArray, threshold: float) -> FloatArray:
    """Return the coefficients (term,) of PySINDy's STLSQ; ``columns`` (value, term) and ``target`` of norm one."""
    try:
        from pysindy.optimizers import STLSQ
    except ImportError as error:
        raise InputError("the peer by sparse regression needs PySINDy: pip install pysindy, or --no-peers") from error
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # that nothing is left is an answer
        found = STLSQ(threshold=threshold, alpha=RIDGE).fit(columns, target)
    return np.asarray(found.coef_, dtype=float).ravel()


def _named(terms: list[Term], coefficients: FloatArray, learned: LatentForces) -> tuple[str, ...]:
    """Return the names of the terms that stay, first the one whose loss would leave most unexplained."""
    names: dict[str, list[int]] = {}
    for number, (term, value) in enumerate(zip(terms, coefficients, strict=True)):
        if value:
            names.setdefault(term.reverse if term.reverse and value < 0 else term.name, []).append(number)
    y = learned.force.ravel()

    def left(without: str) -> float:
        kept = [i for name, numbers in names.items() if name != without for i in numbers]
        X = np.stack([terms[i].force.ravel() for i in kept], axis=1) if kept else np.zeros((len(y), 1))
        return float(np.sum((y - X @ np.linalg.lstsq(X, y)[0]) ** 2))

    return tuple(sorted(names, key=left, reverse=True))
