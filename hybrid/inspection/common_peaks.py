"""Channels that show nothing of what the others show: not connected, or where nothing moves."""

from collections.abc import Sequence

from hybrid.inspection.channel_facts import ChannelFacts

LEAST_CHANNELS = 3  # two that agree, and one that does not
LEAST_SHARE = 0.5  # of the other channels, that show a peak which is common
SAME_PEAK = 0.03  # relative difference of frequencies, or one line of the spectrum where that is more


def common_peaks(facts: Sequence[ChannelFacts], line: float) -> tuple[float, ...]:
    """Return the frequencies of peaks that most channels show, from the lowest, each once.

    In what ``facts`` have, Hz or 1/sample; ``line``: from one line of their spectra to the next.
    """
    alive = [fact for fact in facts if not fact.is_dead]
    found = list[float]()
    for peak in sorted(peak for fact in alive for peak in fact.peaks):
        shown = sum(_shows(fact, peak, line) for fact in alive)
        if shown >= max(2, LEAST_SHARE * len(alive)) and not any(_same(peak, other, line) for other in found):
            found.append(peak)
    return tuple(found)


def without_common_peaks(facts: Sequence[ChannelFacts], line: float) -> tuple[str, ...]:
    """Return the names of channels that show none of the peaks that most of the others have in common."""
    if len(facts) < LEAST_CHANNELS:
        return ()
    common = common_peaks(facts, line)
    if not common:
        return ()
    return tuple(fact.name for fact in facts if not fact.is_dead and not any(_shows(fact, p, line) for p in common))


def _shows(fact: ChannelFacts, peak: float, line: float) -> bool:
    return any(_same(peak, own, line) for own in fact.peaks)


def _same(peak: float, other: float, line: float) -> bool:
    return abs(peak - other) <= max(1.01 * line, SAME_PEAK * max(peak, other))
