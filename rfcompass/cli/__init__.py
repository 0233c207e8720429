"""The command line: `rfcompass COMMAND …`."""

from rfcompass.cli.app import app, main

__all__ = ["app", "main"]
