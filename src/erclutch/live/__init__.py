"""Live at 1 kHz: a loop in C estimates, controls and fails safe; Python starts it, watches, and never stands between.

``frame`` is what the loop writes a step and everybody else reads, through a ring in shared memory.
"""
