"""The Neural Modal ODE: encoder, modal ODE with a learned rest, fixed decoder (Lai et al. 2022)."""
