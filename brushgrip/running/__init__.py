"""What long calculations need: batches, processes elsewhere, interruptions, trials that are kept."""
