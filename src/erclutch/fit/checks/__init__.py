"""What the rows of a log can support is checked before a fit, and each check says what to do: a `Finding`."""
