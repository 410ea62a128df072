"""Frames that the program itself simulates, gravity and large displacements and all, have nothing wrong with them."""

import pytest

import fe_models as fe
import hybrid
from fe_models.structure import Direction
from hybrid.diagnosis.outcome.verdict import Verdict

TUBE = fe.square_tube("tube", 2.1e11, 7850.0, 0.1, 0.004)
PORTAL = fe.Structure(
    name="portal",
    nodes=((0.0, 0.0), (0.0, 3.0), (4.0, 3.0), (4.0, 0.0)),
    elements=tuple(fe.Beam((i, i + 1), TUBE) for i in (1, 2, 3)),
    point_masses=(fe.PointMass(2, 50.0),),
    supports=(fe.Support(1, ("x", "y", "rz")), fe.Support(4, ("x", "y"))),
    damping=fe.Damping(modal_ratios=(0.01,) * 10),
    effects=(fe.DeadLoad(),),
).refined(4)
GIRDER = fe.Structure(
    name="girder",
    nodes=((0.0, 0.0), (2.0, 0.0), (4.0, 0.0), (7.0, 0.0)),
    elements=tuple(fe.Beam((i, i + 1), TUBE) for i in (1, 2, 3)),
    supports=(fe.Support(1, ("x", "y")), fe.Support(3, ("y",)), fe.Support(4, ("y",))),
    damping=fe.Damping(modal_ratios=(0.01,) * 10),
    effects=(fe.DeadLoad(),),
).refined(4)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("design", "sensors", "pulled"),
    [(PORTAL, ("a2x", "a3x", "a3y"), (3, "x")), (GIRDER, ("a2y",), (2, "y"))],
    ids=["portal, one sensor nearly at rest", "girder"],
)
def test_a_clean_frame_of_the_programs_own_has_nothing_wrong(
    design: fe.Structure, sensors: tuple[str, ...], pulled: tuple[int, Direction]
) -> None:
    """With steps of 1 ms an axial force and two machines were named: modes at 28 Hz are 0.3 % too slow then."""
    pulls = [fe.PointLoad(*pulled, force) for force in (100.0, -80.0, 60.0)]
    data = fe.simulate(design, sensors, pulls=pulls, duration=10.0, seed=3).split(0.67)
    report = hybrid.diagnose(design, data)
    assert report.verdict is Verdict.NOTHING_WRONG, report
