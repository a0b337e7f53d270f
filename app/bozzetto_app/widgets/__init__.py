"""Small controls that know nothing of the program: sliders, fields, choices."""
