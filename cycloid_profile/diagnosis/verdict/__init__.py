"""From the best set to the result: acceptance, alternatives, remainder, JSON."""
