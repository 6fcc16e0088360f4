"""What `erclutch live` makes of its options, and what it tells of a session."""
