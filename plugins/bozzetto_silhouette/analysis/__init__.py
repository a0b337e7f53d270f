"""How true a solid is to its drawing, and its report. Imports solids and below."""
