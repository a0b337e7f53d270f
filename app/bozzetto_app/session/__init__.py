"""What is open and what is being done to it; panels and canvas watch it. No widgets."""
