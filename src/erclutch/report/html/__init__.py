"""The report as HTML has one class and one template for each section."""
