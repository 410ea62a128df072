"""One recording as the nominal and the extended model forecast it, for a picture."""

from dataclasses import dataclass

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.recordings import Sensor
from fe_models.spectra import line_frequencies, windowed_spectrum
from hybrid.diagnosis.fitting.forecast_score import ForecastModel, predicted, shown_of
from hybrid.diagnosis.observed.config import EXAMPLE
from hybrid.diagnosis.recorded.batches import Batch
from hybrid.diagnosis.recorded.noise_model import SensorRoles
from hybrid.figures import PANEL_WIDTH, ZOOM_WIDTH, Sheet, channel_labels, clearest_span, figure, show_part

COLOURS = {"nominal": "#E69F00", "extended": "#0072B2"}  # of Okabe & Ito: distinguished by everyone
LINE_WIDTHS = {"nominal": 2.2, "extended": 1.0}  # so that where both are the same both are seen


@dataclass(frozen=True)
class Example:
    """``recording``: its name. ``measured``, ``nominal``, ``extended``: channels (time, sensor) behind their first
    fifth, which ends at ``first`` (s); ``rate`` and natural ``frequencies`` (mode,) in Hz.
    """

    recording: str
    rate: float
    first: float
    sensors: tuple[Sensor, ...]
    measured: FloatArray
    nominal: FloatArray
    extended: FloatArray
    frequencies: FloatArray

    def most_wrong(self, count: int) -> list[int]:
        """Return the columns of ``count`` channels, in order: one that was held out, if any, and else measured ones, of
        each those that the nominal model forecasts worst.
        """
        error = np.nan_to_num(np.std(self.measured - self.nominal, axis=0) / self.measured.std(axis=0), nan=np.inf)
        worst = np.argsort(-error, kind="stable").tolist()
        apart = [column for column in worst if self.sensors[column].role == "held_out"]
        fitted = [column for column in worst if column not in apart]
        return sorted([*apart[:1], *fitted, *apart[1:]][:count])

    @property
    def is_long(self) -> bool:
        """Whether a part of it is drawn by itself, too."""
        return self.clearest_part is not None

    @property
    def clearest_part(self) -> tuple[float, float] | None:
        """Begin and end (s) of the part that is drawn beside the whole; None of a short recording."""
        shown = self.most_wrong(EXAMPLE.max_channels)
        return clearest_span(self.time, {name: getattr(self, name)[:, shown] for name in ("measured", *COLOURS)})

    @property
    def time(self) -> FloatArray:
        """The time (time,) of each sample, s."""
        return np.asarray(self.first + np.arange(len(self.measured)) / self.rate)

    def spectrum(self, name: str) -> tuple[FloatArray, FloatArray]:
        """Return frequencies (Hz) and the error's amplitude spectrum, each channel over its size, all in one (rms)."""
        error = (self.measured - getattr(self, name)) / self.measured.std(axis=0)
        amplitude = 2 * np.abs(windowed_spectrum(error)) / np.hanning(len(error)).sum()
        return line_frequencies(len(error), self.rate), np.asarray(np.sqrt((amplitude**2).mean(axis=1)))


def example_of(
    batch: Batch, nominal: ForecastModel, extended: ForecastModel, roles: SensorRoles, frequencies: FloatArray
) -> Example:
    """Return the first recording of a batch as two models forecast it."""
    one = batch.take([0])
    first = shown_of(one.samples)
    before, after = (predicted(model, one, roles)[0, first:] for model in (nominal, extended))
    rate = roles.noise_model.rate
    return Example(one.names[0], rate, first / rate, roles.sensors, one.data[0, first:], before, after, frequencies)


def draw_example(example: Example) -> Sheet:
    """Draw the channels over time, and below them the spectra of the errors with the natural frequencies."""
    shown = example.most_wrong(EXAMPLE.max_channels)
    labels = channel_labels([example.sensors[i] for i in shown])
    time = example.time
    title = f"{example.recording}, forecast from its first fifth"
    curves = {name: getattr(example, name)[:, shown] for name in ("measured", *COLOURS)}
    span = example.clearest_part
    widths = [PANEL_WIDTH] if span is None else [PANEL_WIDTH, ZOOM_WIDTH]
    columns = len(widths)
    with figure((len(shown) + 1) * columns, columns, title, widths) as (sheet, every):
        axes = every[::columns]
        for row, (column, label) in enumerate(zip(shown, labels, strict=True)):
            drawn = every[row * columns : (row + 1) * columns]
            for axis in drawn:
                axis.plot(
                    time, curves["measured"][:, row], label="measured", color="#555555", linewidth=3.2, alpha=0.45
                )
                for name, colour in COLOURS.items():
                    axis.plot(time, curves[name][:, row], label=name, color=colour, linewidth=LINE_WIDTHS[name])
            drawn[0].set_ylabel(label)
            drawn[0].margins(x=0)
            low, high = example.measured[:, column].min(), example.measured[:, column].max()
            padding = EXAMPLE.padding_share * (high - low)
            drawn[0].set_ylim(low - padding, high + padding)  # a forecast may run away
            if span is not None:
                show_part(drawn[0], drawn[1], span)
        if span is not None:
            every[-3].set_xlabel("time (s)")
            every[-1].remove()
        axes[-2].set_xlabel("time (s)")
        for name, colour in COLOURS.items():
            axes[-1].semilogy(*(part[1:] for part in example.spectrum(name)), color=colour, linewidth=LINE_WIDTHS[name])
        for frequency in example.frequencies:
            axes[-1].axvline(frequency, color="#999999", linewidth=0.7, linestyle=":")
        axes[-1].set(xlabel="frequency (Hz); dotted: natural frequencies", ylabel="error / size")
        widest = EXAMPLE.max_frequency_ratio * example.frequencies.max() if len(example.frequencies) else example.rate
        axes[-1].set_xlim(0, min(widest, example.rate / 2))
        sheet.figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=3, frameon=False)
    return sheet
