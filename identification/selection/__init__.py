"""The search for the missing effects: trials, their scores, and what is selected."""
