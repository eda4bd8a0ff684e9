"""Parameters by nonlinear programming, their covariance and their profiles."""
