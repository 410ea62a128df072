"""Finite element models of frames and chains: structures, matrices, modes, simulation, recordings, pictures."""
