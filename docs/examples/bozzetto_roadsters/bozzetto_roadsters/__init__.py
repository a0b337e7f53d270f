"""A template for the car modeler of Bozzetto: a roadster."""
