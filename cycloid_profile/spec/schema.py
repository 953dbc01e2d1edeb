"""JSON Schema of the spec file, for editors that complete and check TOML."""

from __future__ import annotations

import json

import msgspec

from cycloid_profile.spec.model import Spec

SCHEMA_FILE = "cycloid-profile.schema.json"


def spec_schema() -> str:
    """The schema as JSON text, the same bytes for the same model."""
    schema = msgspec.json.schema(Spec)
    schema["$schema"] = "https://json-schema.org/draft/2020-12/schema"
    schema["title"] = "cycloid_profile spec file"
    return json.dumps(schema, indent=1, ensure_ascii=False) + "\n"
