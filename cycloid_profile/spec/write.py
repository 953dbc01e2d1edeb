"""Write a spec back to TOML, defaults left out."""

from __future__ import annotations

import msgspec

from cycloid_profile.spec.model import Spec
from cycloid_profile.spec.schema import SCHEMA_FILE


def format_spec(spec: Spec, schema: str = SCHEMA_FILE) -> str:
    """TOML text that reads back to an equal ``Spec``; its first line points editors to ``schema``."""
    import tomli_w

    body = tomli_w.dumps(msgspec.to_builtins(spec))
    return f"#:schema {schema}\n{body}"
