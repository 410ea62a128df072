"""Hypotheses held against each other: one cause more, two at once, in some recordings only."""
