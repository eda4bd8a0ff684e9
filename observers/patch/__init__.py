"""The contact patch along a recording: its memory, torque, slopes and full slide."""
