"""Least squares with bounds, variable projection and the intervals of what they find: nothing here knows a law."""
