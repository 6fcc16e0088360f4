"""Readers of log files: one file a format."""
