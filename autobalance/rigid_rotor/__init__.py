"""What adds up: mass moments, unbalance, tolerance. numpy only."""
