"""Planners: they act on estimates and never see truth."""
