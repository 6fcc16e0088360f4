"""Each reader of log files is a file in this folder: one file a format."""
