"""The chain of the audit: two masses, a cause hidden in it, nominal values off by what is normal."""

from dataclasses import dataclass

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.causes.candidate import Candidate
from fe_models.causes.places import Motion
from fe_models.recordings import Dataset, Recording, Sensor
from fe_models.structure import Damping, PointMass, Spring, Structure
from hybrid.diagnosis.nominal.candidates import all_candidates
from hybrid.diagnosis.nominal.nominal_model import NominalModel
from hybrid.diagnosis.nominal.structure_model import nominal_model_of
from hybrid.diagnosis.response.hypothesis import Hypothesis

COUNT, RATE, SAMPLES = 2, 20.0, 201
DESIGN = Structure(
    "chain of two",
    tuple((float(node), 0.0) for node in range(COUNT)),
    tuple(Spring((node,) if node == 1 else (node - 1, node), "x", 100.0) for node in range(1, COUNT + 1)),
    point_masses=tuple(PointMass(node, 1.0) for node in range(1, COUNT + 1)),
    directions=("x",),
    damping=Damping(modal_ratios=(0.01,)),
)
SENSORS = tuple(Sensor(f"a{node}", node, "x", "acceleration", "m/s^2") for node in (1, 2))
KINDS = ("stiffness_change", "added_mass", "support_spring")
SIZES = {"stiffness_change": (-1, 0.03, 0.4), "added_mass": (1, 0.03, 0.4), "support_spring": (1, 2.0, 30.0)}
"""Sign, smallest and largest of a case: from hardly seen to surely seen (of the spring, kg, N/m)."""


@dataclass(frozen=True, eq=False)
class Problem:
    """The ``nominal`` chain, and the ``candidates`` for what is wrong with it."""

    nominal: NominalModel
    candidates: tuple[Candidate, ...]

    @staticmethod
    def of(search: str) -> "Problem":
        """Return the chain's, as the search by "modes" or "series" has it."""
        still = np.random.default_rng(0).standard_normal((1, SAMPLES, len(SENSORS)))
        dataset = Dataset(DESIGN, RATE, SENSORS, (Recording("r", still),))
        nominal = nominal_model_of(dataset)
        usual = Motion(*np.random.default_rng(0).standard_normal((2, 50, COUNT)))  # it sizes force laws alone
        every = all_candidates(nominal, dataset, usual, tuple(range(len(SENSORS))))
        own = tuple(item for item in every if item.kind in KINDS)
        return Problem(nominal.undispersed if search == "modes" else nominal, own)

    def hypothesis(self, candidate: Candidate | None = None) -> Hypothesis:
        """Return that of a candidate, or of none."""
        return Hypothesis(self.nominal) if candidate is None else Hypothesis(self.nominal, (candidate,))

    def true_case(self, rng: np.random.Generator) -> tuple[Hypothesis, FloatArray]:
        """Return a hypothesis and its theta (parameter,): values off as is normal, a size that may hardly be seen."""
        candidate = self.candidates[int(rng.integers(len(self.candidates)))]
        hypothesis = self.hypothesis(candidate)
        theta = hypothesis.centre + hypothesis.width * rng.standard_normal(len(hypothesis.centre))
        sign, low, high = SIZES[candidate.kind]
        theta[-1] = candidate.neutral[0] + sign * np.exp(rng.uniform(np.log(low), np.log(high)))
        return hypothesis, theta

    def from_prior(
        self, rng: np.random.Generator, number: int, scales: FloatArray | float = 1.0
    ) -> tuple[Hypothesis, FloatArray]:
        """Return the hypothesis of candidate ``number``, in turn, and its theta (parameter,) as its prior has it, with
        nominal values off by ``scales`` (nuisance,) times what is normal.
        """
        hypothesis = self.hypothesis(self.candidates[number % len(self.candidates)])
        width = hypothesis.width.copy()
        width[: hypothesis.nuisances] *= scales
        while True:
            theta = hypothesis.centre + width * rng.standard_normal(len(width))
            if ((theta > hypothesis.lower) & (theta < hypothesis.upper)).all():
                return hypothesis, theta


def log_normal(values: FloatArray, centre: FloatArray, width: FloatArray) -> float:
    """Return the log density of independent normal ``values``."""
    return float(
        np.sum(-0.5 * ((values - centre) / width) ** 2 - np.log(width)) - 0.5 * len(values) * np.log(2 * np.pi)
    )
