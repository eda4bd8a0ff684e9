"""Recordings that are published, and those that come with the package."""
