"""The scene, and advice on the view. Imports operations and below."""
