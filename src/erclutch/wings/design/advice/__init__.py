"""What the core says of several logs, if this wing is there."""
