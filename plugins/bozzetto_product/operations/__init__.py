"""Changes of curves: each a pure function from a network to a network."""
