"""What is shown of a drawing, and what the pen touches. Imports solids and below."""
