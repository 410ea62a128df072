"""Quick looks at all candidates, to choose those that are worth a fit."""
