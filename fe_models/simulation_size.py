"""How much may be simulated: checked before any of it is, so that nobody waits for what will not end."""

from math import isfinite

MOST_STEPS = 10_000_000  # of one motion: about an hour of the bridge
MOST_VALUES = 2**27
"""Numbers of all motions together that are kept: 1 GiB of displacements, velocities and accelerations each."""


def length_faults(duration: float, sampling_rate: float, step: float | None = None, columns: int = 1) -> list[str]:
    """Return what is wrong with a ``duration`` (s), a ``sampling_rate`` (Hz) and a ``step`` (s) of the integrator.

    ``columns``: how many numbers are kept of each sample, of all motions together.
    """
    values = {"duration": duration, "sampling_rate": sampling_rate} | ({} if step is None else {"step": step})
    faults = [
        f"{name} = {value}; must be {'positive' if isfinite(value) else 'finite'}"
        for name, value in values.items()
        if not (isfinite(value) and value > 0)
    ]
    if faults:
        return faults
    samples = duration * sampling_rate
    if samples * columns > MOST_VALUES:
        each = f", of {columns} numbers each" if columns > 1 else ""
        faults.append(
            f"{samples:.3g} samples{each} are more than are kept, {MOST_VALUES:.3g} numbers: "
            "fewer motions, a shorter duration, or a lower sampling rate"
        )
    if step is not None and duration / step > MOST_STEPS:
        faults.append(
            f"{duration:g} s in steps of {step:g} s are {duration / step:.3g} steps; at most {MOST_STEPS:.3g}"
        )
    return faults
