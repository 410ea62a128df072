"""Finite element models of frames and chains: structures, matrices, modes, simulation, recordings, pictures.

What a notebook needs stands here (`docs/api.md`), and is loaded when it is asked for.

::

    import fe_models as fe

    chain = fe.four_dof()
    print(fe.natural_modes(chain))
    data = fe.simulate(chain, sensors=["x4", "a1", "a3", "a4"], noise=0.03, seed=1)
"""

from typing import TYPE_CHECKING

from fe_models.lazy_exports import lazy_exports

if TYPE_CHECKING:
    from fe_models.assembly import linearise as linearise
    from fe_models.base_motion import BaseMotion as BaseMotion
    from fe_models.built_in.bridge import bridge as bridge
    from fe_models.built_in.four_dof import four_dof as four_dof
    from fe_models.causes import AddedMass as AddedMass
    from fe_models.causes import AxialForce as AxialForce
    from fe_models.causes import CoulombFriction as CoulombFriction
    from fe_models.causes import CubicSpring as CubicSpring
    from fe_models.causes import DeadLoad as DeadLoad
    from fe_models.causes import GapStop as GapStop
    from fe_models.causes import HarmonicForce as HarmonicForce
    from fe_models.causes import HystereticSpring as HystereticSpring
    from fe_models.causes import MassChange as MassChange
    from fe_models.causes import ModalDamping as ModalDamping
    from fe_models.causes import PointDamper as PointDamper
    from fe_models.causes import QuadraticDamper as QuadraticDamper
    from fe_models.causes import QuadraticSpring as QuadraticSpring
    from fe_models.causes import SlackCable as SlackCable
    from fe_models.causes import StiffnessChange as StiffnessChange
    from fe_models.causes import SupportSpring as SupportSpring
    from fe_models.errors import InputError as InputError
    from fe_models.files.dataset_file import load_dataset as load_dataset
    from fe_models.files.dataset_file import save_dataset as save_dataset
    from fe_models.files.models import load_model as load_model
    from fe_models.files.structure_file import save_structure as save_structure
    from fe_models.linear import LinearModel as LinearModel
    from fe_models.linear import ModalModel as ModalModel
    from fe_models.mode_estimate import ModeEstimate as ModeEstimate
    from fe_models.modes import mac as mac
    from fe_models.modes import natural_modes as natural_modes
    from fe_models.recordings import Assumptions as Assumptions
    from fe_models.recordings import Dataset as Dataset
    from fe_models.recordings import Load as Load
    from fe_models.recordings import Recording as Recording
    from fe_models.recordings import Sensor as Sensor
    from fe_models.recordings import Uncertainty as Uncertainty
    from fe_models.sections import Section as Section
    from fe_models.sections import rectangle as rectangle
    from fe_models.sections import round_bar as round_bar
    from fe_models.sections import round_tube as round_tube
    from fe_models.sections import round_wire as round_wire
    from fe_models.sections import square_tube as square_tube
    from fe_models.simulated_recordings import simulate as simulate
    from fe_models.statics import PointLoad as PointLoad
    from fe_models.structure import Beam as Beam
    from fe_models.structure import Cable as Cable
    from fe_models.structure import Damping as Damping
    from fe_models.structure import Dashpot as Dashpot
    from fe_models.structure import PointMass as PointMass
    from fe_models.structure import Spring as Spring
    from fe_models.structure import Structure as Structure
    from fe_models.structure import Support as Support

_HOMES = {
    "fe_models.structure": ("Structure", "Beam", "Cable", "Spring", "PointMass", "Dashpot", "Support", "Damping"),
    "fe_models.sections": ("Section", "rectangle", "round_bar", "round_tube", "round_wire", "square_tube"),
    "fe_models.built_in.four_dof": ("four_dof",),
    "fe_models.built_in.bridge": ("bridge",),
    "fe_models.files.models": ("load_model",),
    "fe_models.files.structure_file": ("save_structure",),
    "fe_models.causes": (
        "AddedMass",
        "AxialForce",
        "CoulombFriction",
        "CubicSpring",
        "DeadLoad",
        "GapStop",
        "HarmonicForce",
        "HystereticSpring",
        "MassChange",
        "ModalDamping",
        "PointDamper",
        "QuadraticDamper",
        "QuadraticSpring",
        "SlackCable",
        "StiffnessChange",
        "SupportSpring",
    ),
    "fe_models.linear": ("LinearModel", "ModalModel"),
    "fe_models.assembly": ("linearise",),
    "fe_models.modes": ("natural_modes", "mac"),
    "fe_models.mode_estimate": ("ModeEstimate",),
    "fe_models.statics": ("PointLoad",),
    "fe_models.simulated_recordings": ("simulate",),
    "fe_models.base_motion": ("BaseMotion",),
    "fe_models.recordings": ("Dataset", "Recording", "Sensor", "Load", "Assumptions", "Uncertainty"),
    "fe_models.files.dataset_file": ("load_dataset", "save_dataset"),
    "fe_models.errors": ("InputError",),
}
__all__ = [name for names in _HOMES.values() for name in names]
if not TYPE_CHECKING:  # so that a type checker knows these names alone
    __getattr__, __dir__ = lazy_exports(__name__, _HOMES)
