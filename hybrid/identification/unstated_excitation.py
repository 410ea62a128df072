"""Recordings of which nobody says what moved them, and which are no free decays, as they do not die away."""

from collections.abc import Sequence

import numpy as np

from fe_models.recordings import Recording, Sensor, derivative_orders
from hybrid.identification.config import EXCITATION
from hybrid.identification.excitation import Course, course_of


def unstated_course(
    recording: Recording, sensors: Sequence[Sensor], rate: float, lowpass: float | None, first: float
) -> Course | None:
    """Return how a recording goes on that something unknown drives although nothing is said of it; None of others.

    ``rate``, ``lowpass`` and ``first``, the structure's lowest natural frequency, in Hz. What is said stands, also
    where data contradict.
    """
    if recording.excitation is not None or recording.is_driven:
        return None
    columns = [column for column, sensor in enumerate(sensors) if sensor.role == "measured"]
    count = len(recording.data)
    picks = np.unique(np.linspace(0, count - 1, min(count, EXCITATION.most_motions)).round().astype(int))
    orders = derivative_orders([sensors[column] for column in columns])
    course = course_of([recording.data[pick][:, columns] for pick in picks], rate, first, lowpass or rate / 2, orders)
    return None if course.may_be_free else course
