"""Details on finished surfaces: pressed in, raised, cut through, buttons, and splits."""
