"""The methods of [Györök 2022], kept as baselines: zone state machine, root solve per sample."""
