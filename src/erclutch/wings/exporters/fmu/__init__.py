"""An FMU (functional mock-up unit) is an archive with binaries; FMPy runs it."""
