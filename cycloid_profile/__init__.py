"""Design, compensate and export the cycloid discs of RV reducers and cycloidal drives.

The package holds the steps and domain types (``cp.read_spec``, ``cp.design_disc``, ``cp.Trochoid``); its rooms hold
everything else (``cp.contact``, ``cp.plot``). ``__init__.pyi`` lists all names. Each is imported when first used.
"""

from importlib.metadata import version as _version

import lazy_loader as _lazy

from cycloid_profile.errors import did_you_mean as _did_you_mean

_load, __dir__, __all__ = _lazy.attach_stub(__name__, __file__)
__version__ = _version("cycloid-profile")
__all__ = [*__all__, "__version__"]


def __getattr__(name: str) -> object:
    if name not in __all__:
        remedy = _did_you_mean(name, __all__, "see dir(cycloid_profile)")
        raise AttributeError(f"module 'cycloid_profile' has no attribute '{name}': {remedy}")
    return _load(name)
