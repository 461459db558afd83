"""Mass moments, unbalance and tolerance of a rigid rotor; numpy only."""
