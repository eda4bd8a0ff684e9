"""Rigs and found models as tables, which files hold: reading, checking and showing them."""
