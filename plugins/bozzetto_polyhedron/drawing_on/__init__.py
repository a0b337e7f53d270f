"""What is drawn on a body after it was reconstructed."""
