"""The hybrid model: a Neural Modal ODE learned from sparse measurements on top of a finite element model's modes."""
