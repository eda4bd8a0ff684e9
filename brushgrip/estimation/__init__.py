"""Observers and models run over recordings."""
