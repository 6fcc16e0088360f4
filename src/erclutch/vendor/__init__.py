"""Files of other projects that travel with the package unchanged, each folder with its licence and its origin."""
