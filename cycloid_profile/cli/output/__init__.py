"""What the commands share: options, progress, and output for a terminal or a pipe of any width and encoding."""
