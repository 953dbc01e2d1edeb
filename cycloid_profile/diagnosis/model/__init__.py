"""Hypotheses, their linear and exact response, evidence and tests of the residual."""
