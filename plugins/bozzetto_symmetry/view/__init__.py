"""What is shown, and advice on the view. Imports operations and below."""
