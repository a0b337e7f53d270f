"""The scene of a car, and advice on the view. Imports styling, marking and below."""
