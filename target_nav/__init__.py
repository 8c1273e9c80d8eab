"""target_nav: behaviour-tree missions for small robots that find a thing, go to it and stop there."""

__version__ = "0.1.0"
