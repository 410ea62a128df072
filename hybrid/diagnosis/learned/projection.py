"""The learned force at a place, held against the force laws on the list of causes: how much of it each explains."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from fe_models.arrays import TINY, FloatArray
from fe_models.causes import CoulombFriction, CubicSpring, GapStop, MemorylessLaw, QuadraticDamper, QuadraticSpring
from fe_models.causes.coulomb_friction import CREEP_SHARES
from fe_models.causes.places import STARTING_SHARES
from fe_models.structure import Direction
from hybrid.diagnosis.learned.config import LEARNING
from hybrid.diagnosis.learned.forces import PlaceForce

PLACEHOLDER: tuple[tuple[int], Direction] = (1,), "x"  # a law's place, of which its force knows nothing


@dataclass(frozen=True)
class Projected:
    """What was learned at a ``location``: its ``share`` of all that was learned, and what part each law explains.

    ``laws``: the words of the causes, with "spring" and "dashpot" for what is linear; best first. What ``rest`` names
    stays with the net: no law explains it, not even all of them together.
    """

    location: dict[str, Any]
    share: float
    laws: dict[str, float]
    rest: float


def project(place: PlaceForce) -> Projected:
    """Return the shares of a learned force's mean square that single laws, and all of them together, explain."""
    shapes = law_shapes(place.u, place.v)
    explained = {word: max(_explained(place.force, columns) for columns in tried) for word, tried in shapes.items()}
    everything = np.concatenate([columns for tried in shapes.values() for columns in tried], axis=1)
    ranked = dict(sorted(explained.items(), key=lambda item: -item[1]))
    return Projected(location_of(place.name), place.share, ranked, 1 - _explained(place.force, everything))


def law_shapes(u: FloatArray, v: FloatArray) -> dict[str, list[FloatArray]]:
    """Return for each law its force at elongations ``u`` and rates ``v`` (n,), of any size: columns (n, 1) to try."""
    most, rate = float(np.abs(u).max()), float(np.sqrt(np.mean(v**2)))
    usual = CREEP_SHARES[1] * rate or 1.0  # at rest nothing rubs, whatever it is
    laws: dict[str, list[MemorylessLaw]] = {
        CubicSpring.kind: [CubicSpring(*PLACEHOLDER, 1.0)],
        QuadraticSpring.kind: [QuadraticSpring(*PLACEHOLDER, 1.0)],
        QuadraticDamper.kind: [QuadraticDamper(*PLACEHOLDER, 1.0)],
        CoulombFriction.kind: [CoulombFriction(*PLACEHOLDER, 1.0, usual)],
        GapStop.kind: [GapStop(*PLACEHOLDER, reach * most, 1.0, side) for side in (1, -1) for reach in STARTING_SHARES],
    }
    forces = {word: [np.asarray(law.force(u, v)) for law in tried] for word, tried in laws.items()}
    forces |= {"spring": [u], "dashpot": [v]}
    return {word: [column[:, None] for column in columns] for word, columns in forces.items()}


def location_of(name: str) -> dict[str, Any]:
    """Return the location that a place's name stands for (`connectors.chain_connectors`)."""
    words = name.split()
    if words[-1] == "ground":
        return {"node": int(words[1]), "direction": words[2]}
    return {"nodes": [int(words[1]), int(words[4])], "direction": words[5]}


def _explained(force: FloatArray, columns: FloatArray) -> float:
    """Return the share of the mean square that the best combination of columns (n, law) takes away."""
    total = float(force @ force)
    if total == 0:
        return 0.0
    scaled = columns / np.maximum(np.linalg.norm(columns, axis=0), TINY)
    left = force - scaled @ np.linalg.lstsq(scaled, force, rcond=LEARNING.rank_tolerance)[0]
    return float(np.clip(1 - left @ left / total, 0.0, 1.0))
