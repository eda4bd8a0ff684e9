"""Friction while it is measured: sources of samples, the observer that follows them, and who is told."""
