"""Our own rigs, a file each; its name is what ``--rig`` takes."""
