"""Physical effects beside the declared model, one file each."""
