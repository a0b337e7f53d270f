"""The guide beside the sheet, in Qt. Imports marking and below."""
