"""The page behind ``erclutch app``: a folder of logs and runs, worked on by the same commands as on a command line."""
