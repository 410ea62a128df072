"""Causes of a wrong simulation: each is one file, with all that is said of it.

Hiding a cause in data (Exudyn), looking for it in a reduced model (NumPy, PyTorch), writing it to a structure file and
building it into the extended structure all use the definition here. There are three sorts:

- Effects are part of a structure. A `Part` becomes springs, masses and dashpots; axial forces, dead load and modal
  damping change K or C otherwise. `assembly.linearise` has all of these in its matrices; `matrix_changes` gives them
  alone. The others exert a force that depends on motion or time: a `ForceLaw`, on top of the linear model; a
  `LawWithMemory` also on the way there. Their elongations are measured from the state at rest, where they exert none.
  `laws.force_laws` gives those of a structure.
- Faults of a sensor falsify a recording; faults of a load what is known to act in it.
- The time steps, or the modal model, of the simulation itself.

A cause registers itself where it is defined: `CAUSES` has them all, in the order of the imports below.
"""

# isort: off
from fe_models.causes.force_law import ForceLaw, LawWithMemory, MemorylessLaw
from fe_models.causes.base import CAUSES, Cause, Effect, Part, known_effects
from fe_models.causes.connector import ConnectorEffect
from fe_models.causes.stiffness_change import StiffnessChange
from fe_models.causes.axial_force import AxialForce
from fe_models.causes.dead_load import DeadLoad
from fe_models.causes.added_mass import AddedMass
from fe_models.causes.support_spring import SupportSpring
from fe_models.causes.point_damper import PointDamper
from fe_models.causes.mass_change import MassChange
from fe_models.causes.modal_damping import ModalDamping
from fe_models.causes.cubic_spring import CubicSpring
from fe_models.causes.quadratic_spring import QuadraticSpring
from fe_models.causes.quadratic_damper import QuadraticDamper
from fe_models.causes.coulomb_friction import CoulombFriction
from fe_models.causes.hysteretic_spring import HystereticSpring
from fe_models.causes.gap_stop import GapStop
from fe_models.causes.slack_cable import SlackCable
from fe_models.causes.harmonic_force import HarmonicForce
from fe_models.causes.sensor_fault import SensorEffect
from fe_models.causes.sensor_gain import SensorGain
from fe_models.causes.sensor_delay import SensorDelay
from fe_models.causes.sensor_drift import SensorDrift
from fe_models.causes.load_fault import LoadEffect
from fe_models.causes.load_gain import LoadGain
from fe_models.causes.load_delay import LoadDelay
from fe_models.causes.time_integration import TimeIntegration
from fe_models.causes.wrong_modal_model import WrongModalModel
# isort: on

__all__ = [
    "CAUSES",
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
    "HystereticSpring",
    "LawWithMemory",
    "LoadDelay",
    "LoadEffect",
    "LoadGain",
    "MassChange",
    "MemorylessLaw",
    "ModalDamping",
    "Part",
    "PointDamper",
    "QuadraticDamper",
    "QuadraticSpring",
    "SensorDelay",
    "SensorDrift",
    "SensorEffect",
    "SensorGain",
    "SlackCable",
    "StiffnessChange",
    "SupportSpring",
    "TimeIntegration",
    "WrongModalModel",
    "known_effects",
]
