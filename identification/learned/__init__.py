"""A torque learned from what no effect explains."""
