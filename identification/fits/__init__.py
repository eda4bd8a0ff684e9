"""Parameters by a nonlinear programme, and how sure they are."""
