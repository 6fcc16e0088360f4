"""Recordings of a session are MCAP files; a process writes them, and damaged files can be repaired."""
