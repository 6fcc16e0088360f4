"""A run is a folder that keeps what was asked, read and found."""
