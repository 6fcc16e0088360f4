"""Laws are fitted by variable projection over the shape, with bounded gains inside."""
