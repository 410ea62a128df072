"""Modes that the recordings show, and the user's own simulation of a frame leaves out."""

from hybrid.diagnosis.nominal.plant import Plant


def modes_left_out(plant: Plant, modes: int | None) -> list[str]:
    """Return a note where the simulation keeps fewer ``modes`` than the recordings can show."""
    if modes is None or plant.kept is None or modes >= plant.kept:
        return []
    return [
        f"the simulation keeps {modes} modes, and the recordings can show {plant.kept}: the diagnosis follows these,"
        f" and its scores are with them; set modes = {plant.kept}"
    ]
