"""Formats of measurement systems, each read by the library that knows it."""
