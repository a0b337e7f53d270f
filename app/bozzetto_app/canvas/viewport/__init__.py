"""The two backends that show a scene: software and OpenGL."""
