"""What the user's own simulation assumes, and the diagnosis does not follow."""

from fe_models.recordings import Assumptions
from hybrid.diagnosis.nominal.nominal_model import NominalModel


def ignored_assumptions(nominal: NominalModel, assumptions: Assumptions) -> list[str]:
    """Return a note on fewer modes than the recordings can show, and one on an integrator without its step."""
    modes, notes = assumptions.modes, list[str]()
    shown = nominal.below if nominal.kept is None else nominal.kept
    if modes is not None and modes < shown and assumptions.modal_model is None:
        notes.append(
            f"the simulation keeps {modes} modes, and the recordings can show {shown}: the diagnosis follows"
            f" these, and its scores are with them; set modes = {shown}"
        )
    if assumptions.integrator == "newmark" and assumptions.step is None:
        notes.append('integrator = "newmark" has no step, and counts as exact: give it (s) to have its error reported')
    return notes
