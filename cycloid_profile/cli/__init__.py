"""Command line: one subcommand a file, one library call each."""
