"""Causes that matrices by groups may have: of groups, of nodes, of modes and of sensors, each with its prior."""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import cast

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.causes import (
    AddedMass,
    MassChange,
    ModalDamping,
    PointDamper,
    SensorDelay,
    SensorGain,
    StiffnessChange,
    SupportSpring,
)
from fe_models.causes.added_mass import MAX_REMOVED_SHARE, PRIOR_STD_SHARE_OF_WHOLE
from fe_models.causes.candidate import Candidate, ChangeCandidate, MatrixCandidate
from fe_models.causes.known import Channel, Known, outer
from fe_models.causes.places import Elongation, Motion
from fe_models.causes.stiffness_change import PRIOR_STD_SHARE, REMAINING_SHARES
from fe_models.structure import Direction
from hybrid.diagnosis.nominal.coordinates import Coordinates
from hybrid.diagnosis.nominal.nominal_model import NominalModel
from hybrid.diagnosis.response.reduction import spread_forces

CAUSES_AT_PLACES = (SupportSpring, PointDamper)
CAUSES_ELSEWHERE = (ModalDamping, SensorGain, SensorDelay)


def grouped_candidates(nominal: NominalModel, motion: Motion, channels: tuple[Channel, ...]) -> tuple[Candidate, ...]:
    """Return every cause that modes may show at every place; ``nominal``: of matrices by groups."""
    coordinates = nominal.coordinates
    assert coordinates is not None  # its caller has seen to that
    known = Known(nominal, motion, channels, elongations=_elongations(coordinates))
    pulls = {str(place.location): place.pull[:, None] for place in known.places}
    found: list[Candidate] = [*_groups(nominal), *_masses(known, coordinates)]
    for cause in CAUSES_AT_PLACES:
        at_places = cause.candidates(known)
        found += [replace(own, pulls=pulls[str(own.location)]) for own in at_places]
    for elsewhere in CAUSES_ELSEWHERE:
        found += elsewhere.candidates(known)
    return tuple(found)


def _elongations(coordinates: Coordinates) -> tuple[Elongation, ...]:
    """Return the translations of the nodes at which causes are sought."""
    return tuple(
        ({"node": node, "direction": axis}, (node,), cast(Direction, axis), coordinates.pull(node, axis))
        for node in coordinates.nodes
        for axis in coordinates.directions(node)
    )


def _groups(nominal: NominalModel) -> list[ChangeCandidate]:
    """Return each group softer or stiffer, and lighter or heavier."""
    assert nominal.coordinates is not None
    parts: dict[tuple[str, str], int] = {
        (part.quantity, part.group): number for number, part in enumerate(nominal.parts)
    }
    found = []
    for group in nominal.coordinates.model.groups:
        for kind, quantity, share in (
            (StiffnessChange, "stiffness", group.stiffness),
            (MassChange, "mass", group.mass),
        ):
            if not share.nnz:
                continue
            zero = 0.0 * share
            changes = (zero, zero, share) if quantity == "stiffness" else (share, zero, zero)
            whole = nominal.basis.shape[0] == nominal.dofs.free.sum() == len(nominal.coordinates.drawn.dofs.free_rows)
            found.append(
                ChangeCandidate(
                    kind=kind.kind,
                    location={"group": group.name},
                    names=("factor",),
                    build=partial(_of_group, kind, group.name),
                    neutral=(1.0,),
                    width=(PRIOR_STD_SHARE,),
                    lower=(0.0,),
                    far=REMAINING_SHARES if quantity == "stiffness" else (),
                    changes=changes,
                    pulls=None if whole else spread_forces(nominal, share, PRIOR_STD_SHARE),
                    part=parts.get((quantity, group.name)),
                )
            )
    return found


def _of_group(kind: type[StiffnessChange] | type[MassChange], name: str, factor: float) -> StiffnessChange | MassChange:
    return kind((), factor, name)


def _masses(known: Known, coordinates: Coordinates) -> list[MatrixCandidate]:
    """Return a mass at each node at which causes are sought."""
    width, zero, found = PRIOR_STD_SHARE_OF_WHOLE * coordinates.whole_mass, known.zeros, list[MatrixCandidate]()
    for node, others in coordinates.nodes.items():
        pulls = _pulls(coordinates, node)
        found.append(
            ChangeCandidate(
                kind=AddedMass.kind,
                location={"node": node},
                names=("mass",),
                build=partial(AddedMass, node),
                neutral=(0.0,),
                width=(width,),
                lower=(-MAX_REMOVED_SHARE * coordinates.masses[node],),
                changes=(sum((outer(pull) for pull in pulls), start=zero), zero, zero),
                pulls=np.column_stack(pulls),
                twins=tuple({"node": other} for other in others),
            )
        )
    return found


def _pulls(coordinates: Coordinates, node: int) -> Sequence[FloatArray]:
    return [coordinates.pull(node, axis) for axis in coordinates.directions(node)]
