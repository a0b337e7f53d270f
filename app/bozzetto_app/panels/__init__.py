"""The panels around the sheet, and the controls they are made of."""
