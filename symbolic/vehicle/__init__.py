"""A car's front axle: its steering, its tyres, and the one wheel that stands for both."""
