"""What leaves a command: files whole or not at all, their provenance, code, and the screen."""
