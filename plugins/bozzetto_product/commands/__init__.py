"""Commands on curves, joints, surfaces and rough shapes."""
