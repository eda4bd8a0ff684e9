"""The commands, one file each: what a user types and reads. `tasks` does the work."""
