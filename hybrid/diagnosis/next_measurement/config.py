"""Numbers of the advice on what to measure next, with the reason beside each."""

from dataclasses import dataclass


@dataclass(frozen=True)
class HypothesesConfig:
    """Which hypotheses are to be told apart."""

    min_probability: float = 0.01  # beside the best, that is worth telling apart
    max_hypotheses: int = 5  # the time to compare them grows with the square
    draws: int = 100  # of the data of each: probabilities to some hundredths


@dataclass(frozen=True)
class SamplesConfig:
    """At how many samples the recordings of hypotheses are compared."""

    slopes_at: int = 1000  # samples, of all recordings together
    compared_at: int = 120  # of these, drawn: each stands for as many as there are times as many; more tell the same
    max_recordings: int = 8  # that are looked at; others count as if they were like these
    free_state: float = 3.0  # times the largest entry that was found: how large one may be that no sensor tells


@dataclass(frozen=True)
class ExcitationsConfig:
    """Pulls and blows that are considered."""

    compared_at: int = 120  # values of the recording, drawn
    slopes_at: int = 300  # samples, about
    rest_share: float = 0.1  # of a recording: how long it shows the structure at rest before a blow
    max_places: int = 12


@dataclass(frozen=True)
class AdviceConfig:
    """Which measurements are named."""

    max_listed: int = 3  # most informative measurements, and the best of each kind
    min_telling: float = 0.9  # expected probability of the right one: from there on hypotheses are told apart
    min_helping_share: float = 0.3  # of the probability that is missing: a measurement that takes so much away helps
    min_worth_bits: float = 0.02  # less is next to nothing, and no measurement is named for it
    # probability that the first cause and a rival are mistaken for each other, which then are not told apart
    left_open: float = 0.1


HYPOTHESES = HypothesesConfig()
SAMPLES = SamplesConfig()
EXCITATIONS = ExcitationsConfig()
ADVICE = AdviceConfig()
