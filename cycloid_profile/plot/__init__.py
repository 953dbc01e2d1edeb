"""Figures of results: each function draws one result into given or new axes and returns the axes."""

import lazy_loader as _lazy

# Names are declared in __init__.pyi and imported when first used: each needs the subpackage of its result.
__getattr__, __dir__, __all__ = _lazy.attach_stub(__name__, __file__)
