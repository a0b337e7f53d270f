"""Pictures as arrays and as PNG bytes, and pictures as a document keeps them."""
