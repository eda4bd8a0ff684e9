"""Estimators in compact C, each once for every patch and every measurement model."""
