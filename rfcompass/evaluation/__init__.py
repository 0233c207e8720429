"""Judging estimates against the truth: metrics, statistics and the record of one trial."""
