"""What recordings of free decays tell by themselves, before any model of the structure is fitted to them."""
