"""What is shown, and advice on the view. Imports styling, marking and below."""
