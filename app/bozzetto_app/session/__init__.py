"""Open document and the work on it; panels and canvas watch it. No widgets."""
