"""Fits turn a data set into models with intervals, scored and ranked."""
