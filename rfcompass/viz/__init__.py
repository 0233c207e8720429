"""Figures and pages. Draws records; computes nothing that others need."""
