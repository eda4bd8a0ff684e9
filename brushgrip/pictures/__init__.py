"""Pictures, drawn without pyplot and its global state; style holds what they share."""
