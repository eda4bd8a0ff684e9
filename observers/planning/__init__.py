"""Steering that tells friction with little travel: forecast, plan, and a probe that plans as it goes."""
