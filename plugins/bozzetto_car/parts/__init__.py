"""The parts of a car that is handed over: closed body, windows, wheel arches, wheels."""
