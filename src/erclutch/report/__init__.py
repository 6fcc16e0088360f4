"""The report is one self-contained HTML file made from a run folder alone."""
