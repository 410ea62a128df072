"""How often a diagnosis is right over many blind cases, each rate with its aim and its peers'."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from statistics import median

from scipy.stats import binomtest

from benchmarks.blind.aims import OVER_FLOOR, Aims, aims_of
from benchmarks.blind.cases import BlindResult
from benchmarks.blind_cases import Acts, Excitation, Tier
from benchmarks.peers.answer import PeerMark
from hybrid.diagnosis.track_record.certified import GROUPS

FORECAST = "extended forecast within {exact} (off: {off}) times the noise floor".format(**OVER_FLOOR)
SENSOR_KINDS = ("sensor_gain", "sensor_delay", "sensor_drift", "time_integration")  # no forces on the structure


@dataclass(frozen=True)
class Share:
    """``hits`` of ``count`` cases."""

    hits: int
    count: int

    @property
    def value(self) -> float | None:
        """The share, None of nothing."""
        return self.hits / self.count if self.count else None

    @property
    def interval(self) -> tuple[float, float]:
        """Wilson's 95 % interval of the true rate (Journal of the American Statistical Association 22, 1927)."""
        if not self.count:
            return 0.0, 1.0
        found = binomtest(self.hits, self.count).proportion_ci(0.95, method="wilson")
        return float(found.low), float(found.high)

    def as_json(self) -> dict[str, object]:
        """Return value, counts and interval for a JSON file."""
        return {"value": self.value, "hits": self.hits, "count": self.count, "interval": self.interval}

    def __str__(self) -> str:
        return "-" if not self.count else f"{100 * self.hits / self.count:.0f} % ({self.hits}/{self.count})"


@dataclass(frozen=True)
class Rate:
    """One line: ``what`` was ``measured``, as a share or a plain number, its ``aim``, and the ``peers``' (peer,)."""

    what: str
    measured: Share | float
    aim: str = ""
    peers: tuple[Share | float | None, ...] = ()

    def as_json(self, names: Sequence[str]) -> dict[str, object]:
        """Return the line for a JSON file; ``names`` of the peers."""
        return {
            "what": self.what,
            **_plain(self.measured),
            "aim": self.aim,
            "peers": {
                name: None if value is None else _plain(value) for name, value in zip(names, self.peers, strict=False)
            },
        }


def share(marks: Iterable[bool]) -> Share:
    """Return how many of the marks are true."""
    all_marks = [bool(mark) for mark in marks]
    return Share(sum(all_marks), len(all_marks))


def rates(
    results: Sequence[BlindResult],
    tier: Tier,
    acts: Acts = "all",
    excitation: Excitation = "free",
    *,
    empty: bool = False,
) -> list[Rate]:
    """Return every rate, with the aims of how near the nominal models are (``tier``), where the cause ``acts`` and what
    moves the structure (``excitation``).

    ``empty``: whether rates of no case are among them, too.
    """
    aims = aims_of(tier, acts, excitation)
    names = peer_names(results)
    single = [r for r in results if r.is_single]
    clean, outside = [r for r in results if r.is_clean], [r for r in results if r.is_outside]
    pairs, known = [r for r in results if r.is_pair], [r for r in results if not r.is_outside]

    def line(
        what: str,
        chosen: Sequence[BlindResult],
        own: Callable[[BlindResult], bool],
        target: str,
        peer: Callable[[PeerMark], bool] | None = None,
    ) -> Rate:
        others = [None if peer is None else share(peer(r.peers[name]) for r in chosen) for name in names]
        return Rate(what, share(own(r) for r in chosen), target, tuple(others))

    limit = OVER_FLOOR[tier]
    # Forecasts of test recordings need nothing that acts in one training recording alone; modes alone forecast nothing.
    forecast = excitation != "ambient"
    needing = [r for r in results if not r.is_immaterial] if forecast and acts == "all" else []
    felt, both = [r for r in needing if r.is_single], [r for r in needing if r.is_pair]
    forces = [r for r in single if r.task.hidden not in SENSOR_KINDS]
    found = [
        line("kind and place right, first", single, lambda r: r.judgement.first, aims.first, _first),
        line("the same, of causes that forecasts need", felt, lambda r: r.judgement.first, ""),
        line("the same, of causes that are forces", forces, lambda r: r.judgement.first, "", _first),
        line("first or among the alternatives", single, lambda r: r.judgement.listed, aims.listed),
        line("two at once: both found", pairs, lambda r: r.judgement.first, aims.pairs, _first),
        line("the same, where forecasts need both", both, lambda r: r.judgement.first, ""),
        Rate(
            "wrong name at >= 0.9",
            share(r.judgement.confidently_wrong for r in results),
            aims.wrong,
            tuple(_confidently_wrong([r.peers[name] for r in results]) for name in names),
        ),
        line("clean case called wrong", clean, lambda r: not r.judgement.first, aims.clean, _not_first),
        line(
            "outside the list: said so, nothing named at >= 0.9",
            outside,
            lambda r: r.judgement.first and not r.judgement.confidently_wrong,
            aims.outside,
            _first,
        ),
        *_of_values(results, aims),
        line(FORECAST, known if forecast else [], lambda r: r.judgement.over_floor <= limit, ""),
    ]
    if known and forecast:
        middle = median(r.judgement.over_floor for r in known)
        found.append(Rate("extended forecast / noise floor, median", middle, f"<= {limit}"))
    limit_s = "< 180" if any(r.task.config.structure == "bridge" for r in results) else "< 30"
    times = [[r.judgement.seconds for r in results], *([r.peers[name].seconds for r in results] for name in names)]
    for what, of, target in (("seconds of one core, median", median, ""), ("seconds of one core, worst", max, limit_s)):
        own, *others = (float(of(column)) for column in times)
        found.append(Rate(what, own, target, tuple(others)))
    return [rate for rate in found if empty or not isinstance(rate.measured, Share) or rate.measured.count]


def _of_values(results: Sequence[BlindResult], aims: Aims) -> list[Rate]:
    """Return how well parameters of causes and factors of groups are known."""
    return [
        Rate(
            "parameters within 10 % or two standard deviations",
            share(mark for r in results for mark in r.judgement.within),
            aims.parameters,
        ),
        Rate("95 % intervals cover", share(mark for r in results for mark in r.judgement.covered), "92-98 %"),
        Rate(
            GROUPS,
            share(mark for r in results for mark in r.judgement.groups),
            aims.groups,
        ),
    ]


def peer_names(results: Sequence[BlindResult]) -> tuple[str, ...]:
    """Return the peers that answered in every result."""
    return tuple(name for name in results[0].peers if all(name in r.peers for r in results)) if results else ()


def table(found: Sequence[Rate], names: Sequence[str]) -> str:
    """Return the rates as a table in Markdown; ``names`` of the peers."""
    heads = ["", "diagnosis", "95 % interval", "aim", *names]
    lines = ["| " + " | ".join(heads) + " |", "|" + "---|" * len(heads)]
    for rate in found:
        span = ""
        if isinstance(rate.measured, Share):
            low, high = rate.measured.interval
            span = f"{100 * low:.0f}-{100 * high:.0f} %"
        others = [*rate.peers, *[None] * (len(names) - len(rate.peers))]
        lines.append("| " + " | ".join([rate.what, _cell(rate.measured), span, rate.aim, *map(_cell, others)]) + " |")
    return "\n".join(lines)


def _first(mark: PeerMark) -> bool:
    return mark.first


def _confidently_wrong(marks: Sequence[PeerMark]) -> Share | None:
    """Return how often a peer is, None where it gives no probabilities."""
    if all(mark.answer.probability is None for mark in marks):
        return None
    return share(mark.confidently_wrong for mark in marks)


def _not_first(mark: PeerMark) -> bool:
    return not mark.first


def _cell(value: Share | float | None) -> str:
    return "" if value is None else str(value) if isinstance(value, Share) else f"{value:.4g}"


def _plain(value: Share | float) -> dict[str, object]:
    return value.as_json() if isinstance(value, Share) else {"value": value}
