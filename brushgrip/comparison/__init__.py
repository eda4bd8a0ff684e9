"""The source's Table 6.1 beside ours: methods, scores, tables."""
