"""The same models are fitted to each of many logs or devices; a table and a page show what stands out and drifts."""
