"""From lines on the sheet to ranked answers in space."""
