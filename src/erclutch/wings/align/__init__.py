"""Two logs of one experiment whose clocks differ become one log."""
