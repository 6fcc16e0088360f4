"""Networks are fitted from starts on centroids to weights."""
