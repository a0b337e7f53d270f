"""The recipe: values that a document keeps."""
