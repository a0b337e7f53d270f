"""What needs no gesture."""
