"""Reports of a diagnosis and of a correction."""

import lazy_loader as _lazy

# Names are declared in __init__.pyi and imported when first used: only a correction needs the exporters.
__getattr__, __dir__, __all__ = _lazy.attach_stub(__name__, __file__)
