"""The HTML report has one class and one template for each section."""
