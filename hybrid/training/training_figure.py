"""A picture of a training: what it lost, and how far it forecast."""

from collections.abc import Sequence

from hybrid.figures import STYLES, Sheet, figure
from hybrid.training.gradient_training import EpochResult


def draw_history(history: Sequence[EpochResult]) -> Sheet:
    """Draw the loss a sample over the epochs, and how many samples are forecast in each."""
    from matplotlib.ticker import MaxNLocator  # loaded only where something is drawn

    epochs = [result.epoch for result in history]
    with figure(2, 1, "Training") as (sheet, (loss, horizon)):
        loss.plot(epochs, [result.loss / result.horizon for result in history], **STYLES["hybrid"])
        loss.set_ylabel("loss a sample")
        horizon.plot(epochs, [result.horizon for result in history], **STYLES["measured"])
        horizon.set(xlabel="epoch", ylabel="forecast (samples)", ylim=(0, None))
        for axis in (loss, horizon):
            axis.xaxis.set_major_locator(MaxNLocator(integer=True))
    return sheet
