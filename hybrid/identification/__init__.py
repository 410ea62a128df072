"""What recordings of free decays show by themselves, before any model of the structure is fitted to them."""
