"""A model is a device, stages, a law or a network, and their numbers. Nothing in this room knows of fits."""
