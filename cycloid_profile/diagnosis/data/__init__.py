"""Measured files made ready: rows, noise, repeats, refusals."""
