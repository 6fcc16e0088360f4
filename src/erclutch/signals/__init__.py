"""This room holds what was measured: recordings, units, devices, clocks, and speed from position."""
