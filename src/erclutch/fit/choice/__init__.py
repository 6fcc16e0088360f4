"""Which model is recommended, by training rows that its fit has not seen; and how good it is, by rows held out."""
