"""Speed and accuracy against plain solutions and against a peer; see docs/benchmarks.md."""
