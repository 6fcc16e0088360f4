"""The TWIN is calibrated to a log or to the figures that the paper prints."""
