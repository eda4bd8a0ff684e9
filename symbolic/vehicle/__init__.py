"""A car's front axle: its steering, its tyres, and the mean wheel."""
