"""Operations on solved curves: trim, snap, split. Imports solve and below."""
