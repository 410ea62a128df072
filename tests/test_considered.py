"""What a diagnosis by modes considered stands on its page: words, probability, and what each hypothesis leaves."""

from dataclasses import replace

from hybrid.diagnosis.modes_and_motion.considered import NOTHING_ELSE, ConsideredHypothesis
from hybrid.report.page import Paragraph, Table
from hybrid.report.rejected import LEFT_OF_MODES, LEFT_OF_MOTION, NONE_REJECTED, rejected
from tests.pages import answer_by_modes, chain_dataset

FOUND = ConsideredHypothesis("stiffness change at element 3", 0.97, 1.02)
OTHER = ConsideredHypothesis("added mass at node 2 in after", 0.02, 4.5)
NOTHING = ConsideredHypothesis(NOTHING_ELSE, 1e-9, 31.0)
PLACED = (FOUND, OTHER, NOTHING)
LAWS = (
    ConsideredHypothesis("cubic spring at node 4 in x", 0.9, 0.004),
    ConsideredHypothesis("no force law", 0.05, 0.021),
)


def rows_of(table: Table) -> list[tuple[str, ...]]:
    return [tuple(cell.text for cell in row) for row in table.rows]


def test_what_was_considered_by_modes_and_by_motion_stands_in_two_tables() -> None:
    found = replace(
        answer_by_modes(chain_dataset()),
        competed=("stiffness_change", "added_mass"),
        considered=PLACED,
        considered_laws=LAWS,
    )
    kinds, modes, laws = rejected(found)
    assert isinstance(kinds, Paragraph)
    assert kinds.text == "Competed, each at all its places: added mass, stiffness change."
    assert isinstance(modes, Table) and isinstance(laws, Table)
    assert rows_of(modes) == [
        ("stiffness change at element 3", "97 %", "1.02"),
        ("added mass at node 2 in after", "2 %", "4.5"),
        ("no cause, nominal values alone", "less than 0.1 %", "31"),
    ]
    assert rows_of(laws) == [("cubic spring at node 4 in x", "90 %", "0.4 %"), ("no force law", "5 %", "2.1 %")]
    assert modes.note.startswith(LEFT_OF_MODES) and laws.note == LEFT_OF_MOTION


def test_a_page_without_other_hypotheses_says_so() -> None:
    _, said = rejected(answer_by_modes(chain_dataset()))
    assert isinstance(said, Paragraph) and said.text == NONE_REJECTED
