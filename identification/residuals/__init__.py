"""Which signals a residual follows, and whether it is more than noise."""
