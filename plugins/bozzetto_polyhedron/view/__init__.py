"""What is shown on the sheet and in space."""
