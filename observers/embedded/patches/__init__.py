"""The contact patch in compact C: one interface, and its realisations by corners and by bristles."""
