"""What a dataset in memory may know that a dataset file has no words for."""

from fe_models.recordings import Dataset, Recording


def unsaid_faults(dataset: Dataset) -> list[str]:
    """Return a fault for each thing without which a dataset, read again, would be another one.

    That a base moves already when a recording begins matters to sensors alone that show its velocity or displacement.
    """
    faults = list[str]()
    if dataset.load_course != "smooth" and dataset.is_loaded:
        faults.append(
            f"load_course = {dataset.load_course!r}: a dataset file cannot say that known forces go otherwise than"
            ' smoothly between their samples; save dataclasses.replace(dataset, load_course="smooth"), and set it again'
            " where it is read"
        )
    for recording in dataset.recordings:
        sensors = _shown_the_base(dataset, recording)
        if sensors:
            faults.append(
                f"recording {recording.name!r}: its base moves already when it begins, as it is a part of a longer one;"
                f" a dataset file cannot say so, and {', '.join(sensors)} would be taken wrongly: keep the files that"
                " it was read from, or save it without these sensors"
            )
    return faults


def unsaid_notes(dataset: Dataset) -> list[str]:
    """Return a line for each recording that begins behind the begin of a longer one, from which its time counts on."""
    return [
        f"{recording.name!r} begins {recording.skipped} samples after the recording that it is a part of; read from"
        " here, its time begins at zero"
        for recording in dataset.recordings
        if recording.skipped
    ]


def _shown_the_base(dataset: Dataset, recording: Recording) -> list[str]:
    """Return the sensors that show what velocity or displacement a base of the recording begins with."""
    moving = [motion.along for motion in recording.base if any(motion.begun)]
    return [
        sensor.name
        for sensor in dataset.sensors
        if sensor.reference == "absolute"
        and sensor.quantity != "acceleration"
        and any(sensor.shown_of(along) for along in moving)
    ]
