"""By which options a command of this wing reads a file of points, for what `inspect` prints."""
