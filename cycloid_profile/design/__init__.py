"""From a spec to a finished design: checks, key figures, accuracy and tolerance record."""

import lazy_loader as _lazy

# Names are declared in __init__.pyi and imported when first used: a diagnosis needs no tolerance study.
__getattr__, __dir__, __all__ = _lazy.attach_stub(__name__, __file__)
