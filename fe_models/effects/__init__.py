"""Effects a simulation may lack, each defined once: name, place, parameters with units, and what it does.

Hiding an effect in data (Exudyn), looking for it in a reduced model (NumPy, PyTorch), writing it to a structure file
and building it into the extended structure all use the definition here. There are two sorts:

- Linear effects change M, C or K: `parts` (they become springs, masses and dashpots of the structure), `axial_force`,
  `dead_load`, `modal_damping`. `assembly.linearise` has them in its matrices; `matrix_changes` gives them alone.
- The others exert a force that depends on motion or time: a `ForceLaw`, on top of the linear model. Their elongations
  are measured from the state at rest, where they exert none. `laws.force_laws` gives those of a structure.

What falsifies recordings or the simulation itself, and is no part of a structure, is in `sensor_effects`,
`time_integration` and `wrong_modal_model`; `causes` knows all kinds.
"""

from fe_models.effects.axial_force import AxialForce
from fe_models.effects.base import Cause, Effect, ForceLaw
from fe_models.effects.connectors import ConnectorEffect, CoulombFriction, CubicSpring, GapStop, QuadraticDamper
from fe_models.effects.dead_load import DeadLoad
from fe_models.effects.harmonic_force import HarmonicForce
from fe_models.effects.modal_damping import ModalDamping
from fe_models.effects.parts import AddedMass, PointDamper, StiffnessChange, SupportSpring
from fe_models.effects.slack_cable import SlackCable

EFFECTS: dict[str, type[Effect]] = {
    effect.kind: effect
    for effect in (
        StiffnessChange,
        AddedMass,
        SupportSpring,
        AxialForce,
        DeadLoad,
        ModalDamping,
        PointDamper,
        QuadraticDamper,
        CoulombFriction,
        CubicSpring,
        GapStop,
        SlackCable,
        HarmonicForce,
    )
}

__all__ = [
    "EFFECTS",
    "AddedMass",
    "AxialForce",
    "Cause",
    "ConnectorEffect",
    "CoulombFriction",
    "CubicSpring",
    "DeadLoad",
    "Effect",
    "ForceLaw",
    "GapStop",
    "HarmonicForce",
    "ModalDamping",
    "PointDamper",
    "QuadraticDamper",
    "SlackCable",
    "StiffnessChange",
    "SupportSpring",
]
