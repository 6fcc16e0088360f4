"""Time stamps become a clock: a start, a period, gaps. A recording is cut to a window or brought to another rate."""
