"""Kinds of model, a file each: laws, networks, and laws with a network on their residual."""
