"""What a workshop identifies of a car: its gear and its return torque, and its tyres."""
