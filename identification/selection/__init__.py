"""Stepwise selection of the missing effects: trials, the criteria that compare them, and the search."""
