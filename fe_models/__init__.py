"""Finite element models of frames and chains: structures, matrices, modes, nonlinear simulation, recordings, pictures."""
