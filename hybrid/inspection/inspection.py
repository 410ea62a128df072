"""The first look at a recording file, whole: read, channel by channel, and as one motion."""

from dataclasses import dataclass, replace
from pathlib import Path

from fe_models.files.signals import Signals, read_signals
from fe_models.quiet_start import quiet_start
from hybrid.inspection.channel_facts import ChannelFacts, channel_facts, spectrum
from hybrid.inspection.common_peaks import common_peaks, without_common_peaks
from hybrid.inspection.likely_excitation import Guess, Moved, likely_excitation


@dataclass(frozen=True)
class Inspection:
    """The ``signals`` of a file, the ``facts`` of each channel, and a ``guess`` of what moved the structure."""

    signals: Signals
    facts: tuple[ChannelFacts, ...]
    guess: Guess

    @property
    def duration(self) -> float | None:
        """How long the recording lasts, s; None where the file does not say its rate."""
        rate = self.signals.sampling_rate
        return None if rate is None else len(self.signals.values) / rate

    @property
    def quiet(self) -> int:
        """Samples before anything moves, where no force is known; 0 where it moves at once."""
        is_driven = bool(self.guess.channels)
        return 0 if is_driven or self.guess.moved is Moved.AMBIENT else quiet_start(self.signals.values)

    @property
    def common_peaks(self) -> tuple[float, ...]:
        """Frequencies (Hz, or 1/sample without a rate) of the peaks that most channels of the structure show."""
        return common_peaks(self._moving, self._line)

    @property
    def apart(self) -> tuple[str, ...]:
        """Names of channels that show none of the common peaks."""
        return without_common_peaks(self._moving, self._line)

    @property
    def _moving(self) -> list[ChannelFacts]:
        return [fact for channel, fact in enumerate(self.facts) if channel not in self.guess.channels]

    @property
    def _line(self) -> float:
        frequencies, _ = spectrum(self.signals.values[:, 0], self.signals.sampling_rate)
        return float(frequencies[1]) if len(frequencies) > 1 else 0.0


def inspect_file(path: Path, key: str | None = None, sampling_rate: float | None = None) -> Inspection:
    """Return what is in a recording file; ``key`` names one of several arrays, ``sampling_rate`` (Hz) replaces its own.

    `InputError` where it cannot be read.
    """
    signals = read_signals(path, key)
    if sampling_rate is not None:
        signals = _at(signals, sampling_rate)
    facts = tuple(
        channel_facts(name, unit, signals.values[:, column], signals.sampling_rate)
        for column, (name, unit) in enumerate(zip(signals.names, signals.units, strict=True))
    )
    return Inspection(signals, facts, likely_excitation(signals.names, signals.units, signals.values))


def _at(signals: Signals, sampling_rate: float) -> Signals:
    own = signals.sampling_rate
    contradicts = own is not None and abs(sampling_rate / own - 1) > 0.01
    notes = [f"the sampling rate given, {sampling_rate:g} Hz, is not the file's, {own:g} Hz"] if contradicts else []
    return replace(signals, sampling_rate=sampling_rate, rate_from="as given", notes=(*signals.notes, *notes))
