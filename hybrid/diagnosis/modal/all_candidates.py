"""Causes that a search by modes looks for, of structures and of matrices by groups."""

from fe_models.causes.candidate import Candidate
from fe_models.causes.known import Channel, Known
from fe_models.causes.places import Motion
from fe_models.causes.searched import candidates_of
from hybrid.diagnosis.modal.grouped_candidates import grouped_candidates
from hybrid.diagnosis.nominal.nominal_model import NominalModel


def all_candidates_of(nominal: NominalModel, motion: Motion, channels: tuple[Channel, ...]) -> tuple[Candidate, ...]:
    """Return every cause at every place that it can have."""
    if nominal.coordinates is not None:
        return grouped_candidates(nominal, motion, channels)
    return candidates_of(Known(nominal, motion, channels))
