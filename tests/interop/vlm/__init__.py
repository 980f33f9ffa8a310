"""Servers of models that mean nothing drive the robot: `./dev interop vlm`."""
