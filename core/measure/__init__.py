"""How good a motion is: one entry for each metric."""
