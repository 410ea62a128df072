"""The structures that come with the program: the chain and the bridge of Lai et al. 2022."""
