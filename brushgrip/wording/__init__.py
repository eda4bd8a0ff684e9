"""Figures and findings as text."""
