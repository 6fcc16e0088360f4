"""How far the measured effort may lie from an estimate: bands by cells, at new fields, in haste."""
