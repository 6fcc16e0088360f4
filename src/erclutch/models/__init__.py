"""Models: a device, stages, a law or a network, and their numbers. Nothing here knows of fits."""
