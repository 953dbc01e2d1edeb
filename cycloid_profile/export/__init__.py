"""Exact outlines and tooth profiles as files of other programs, each read back and measured."""

import lazy_loader as _lazy

# Names are declared in __init__.pyi and imported when first used: writing a report needs no CAD exporter.
__getattr__, __dir__, __all__ = _lazy.attach_stub(__name__, __file__)
