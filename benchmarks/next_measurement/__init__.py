"""How good advice on the next measurement is: blind cases that few sensors leave open, measured again."""
