"""Universal Scene Description (USD), written: as text, and as a package for phones."""
