"""The surface of a loop: exact on its curves, smooth over smooth edges, fair inside."""
