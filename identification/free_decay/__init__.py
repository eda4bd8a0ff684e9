"""k and b_t from the free vibration after an impact, by maximum likelihood."""
