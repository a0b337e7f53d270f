"""What can be done to solved curves: trim, snap, split. Imports solve and below."""
