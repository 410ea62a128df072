"""What to measure next, ranked by what it is expected to tell about which hypothesis is right."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from hybrid.diagnosis.next_measurement.config import ADVICE
from hybrid.diagnosis.next_measurement.hypotheses import Cause, Rivals
from hybrid.diagnosis.next_measurement.information import Prediction, distances, least_information, outcome
from hybrid.diagnosis.next_measurement.measurements import Measurement
from hybrid.diagnosis.probability import two_decimals

ANYTHING, SENSORS = "added sensor, pull or blow", "added sensor"  # what was considered, for a sentence


@dataclass(frozen=True)
class Option:
    """A ``measurement``, the ``information`` (bits) to expect of it about which hypothesis is right, and the
    ``probability`` to expect that the one that is likeliest with it is right.
    """

    measurement: Measurement
    information: float
    probability: float


@dataclass(frozen=True)
class NextMeasurement:
    """The ``options``, most informative first, to tell ``causes`` apart, the likeliest first; empty where none is of
    use. ``now``: the probability of the first cause. ``open``: those causes that even the first option leaves open.
    ``considered``: of which measurements they are the best, in words.
    """

    options: tuple[Option, ...]
    causes: tuple[Cause, ...]
    now: float
    open: tuple[Cause, ...]
    considered: str = ANYTHING

    @property
    def sentences(self) -> tuple[str, ...]:
        """What to do, in words, most important first."""
        first, told = self.causes[0], [cause for cause in self.causes[1:] if cause not in self.open]
        lines = list[str]()
        if self.options:
            best = self.options[0]
            expected, now = two_decimals(best.probability), two_decimals(self.now)
            numbers = f"expected probability of the right one: {expected}; now {now}"
            others = _listed([cause.words for cause in told or self.causes[1:]])
            lines.append(f"{best.measurement.words} {self._verb(best)} {first.words} from {others} ({numbers})")
            if len(self.options) > 1:
                more = [f"{own.measurement.title} ({two_decimals(own.probability)})" for own in self.options[1:]]
                lines.append(f"next best: {'; '.join(more)}")
        if self.open:
            which = "none of these tells" if self.options else f"no {self.considered} tells"
            others = _listed([cause.words for cause in self.open])
            lines.append(f"{which} {first.words} from {others}: look at the structure there")
        return tuple(lines)

    def _verb(self, best: Option) -> str:
        if best.probability >= ADVICE.min_telling:
            return "would tell"
        if 1 - best.probability <= (1 - ADVICE.min_helping_share) * (1 - self.now):
            return "would help to tell"
        return "would hardly tell, but better than any other,"

    def as_json(self) -> dict[str, Any]:
        """Return it as plain data."""
        return {
            "options": [
                {
                    "kind": option.measurement.kind,
                    "node": option.measurement.node,
                    "direction": option.measurement.direction,
                    **({"quantity": option.measurement.quantity} if option.measurement.quantity else {}),
                    "information_bits": option.information,
                    "probability_then": option.probability,
                }
                for option in self.options
            ],
            "causes": [vars(cause) for cause in self.causes],
            "probability_now": self.now,
            "left_open": [vars(cause) for cause in self.open],
            "sentences": list(self.sentences),
        }


Predicted = Callable[[], Sequence[Prediction]]
"""What each hypothesis predicts of a measurement, (hypothesis,): made when it is asked for, as all are many."""


def recommended(
    rivals: Rivals, predicted: Mapping[Measurement, Predicted], considered: str = ANYTHING
) -> NextMeasurement:
    """Return what to measure next, of all measurements that are possible, with what is ``predicted`` of each;
    ``considered``: which these are, in words.

    Ranked by a bound of the information that is closed-form and tells measurements apart that leave next to no doubt;
    what is expected of the best ones is then drawn.
    """
    weights = rivals.weights
    apart = {item: distances(own()) for item, own in predicted.items()} if len(weights) > 1 else {}
    least = {item: least_information(weights, own) for item, own in apart.items()}
    ranked = sorted(least, key=lambda item: -least[item])
    best_of_kind = [next((item for item in ranked if item.kind == kind), None) for kind in ("sensor", "pull", "hammer")]
    wanted = [item for item in ranked if item in ranked[: ADVICE.max_listed] or item in best_of_kind]
    rng = np.random.default_rng(0)
    found = [(item, outcome(weights, predicted[item](), rng, rivals.alike)) for item in wanted]
    options = tuple(
        Option(item, own.information, rivals.share * own.probability)
        for item, own in found
        if own.information > ADVICE.min_worth_bits
    )
    left = _left_open(rivals, apart[options[0].measurement] if options else None)
    return NextMeasurement(options, rivals.causes, rivals.causes[0].probability, (*left, *rivals.twins), considered)


def _left_open(rivals: Rivals, apart: Any) -> tuple[Cause, ...]:
    """Return the rivals that may be mistaken for the first cause: of two with weights w the error is at most
    sqrt(w_1 w_2) exp(-B) of their sum (Bhattacharyya's bound).
    """
    if apart is None:
        return rivals.causes[1:]
    weights = rivals.weights
    error = np.sqrt(weights[0] * weights) * np.exp(-apart[0]) / (weights[0] + weights)
    return tuple(cause for cause, own in zip(rivals.causes[1:], error[1:], strict=True) if own > ADVICE.left_open)


def _listed(words: Sequence[str]) -> str:
    return " or ".join([", ".join(words[:-1]), words[-1]]) if len(words) > 1 else words[0]
