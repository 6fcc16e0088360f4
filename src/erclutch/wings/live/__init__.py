"""A loop in C estimates, controls and fails safe at 1 kHz; Python starts it, watches, and never stands between.

``ring`` holds what the loop writes each step; ``layout`` reads from ``c/erc_layout.h`` what C and Python share.
"""
