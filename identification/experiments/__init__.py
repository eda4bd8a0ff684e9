"""Experiments that would separate two effects."""
