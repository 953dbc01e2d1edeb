"""``python -m cycloid_profile`` is the command line."""

from cycloid_profile.cli.main import main

main()
