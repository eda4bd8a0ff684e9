"""Recordings and rigs from files."""
