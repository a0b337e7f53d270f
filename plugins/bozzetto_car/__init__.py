"""The car modeler: from a sketch and a few marks to a styled body that CAD opens exactly."""
