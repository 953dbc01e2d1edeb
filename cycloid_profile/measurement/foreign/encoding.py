"""Text of a file of another program: UTF-8, UTF-16, GB18030 or cp1252, found without statistics.

A statistical detector was tried (charset-normalizer): a measured file has a handful of letters outside ASCII, and it
read "µm" and "°" of cp1252 as Chinese. Four encodings are distinguished by their own rules.
"""

from __future__ import annotations

import codecs
import re

_CONTROL = re.compile(r"[\x00-\x08\x0e-\x1f\x7f]")
_HANZI = re.compile(r"[\u3400-\u9fff]+")
_BYTE_ORDER_MARKS = ((codecs.BOM_UTF8, "utf-8-sig"), (codecs.BOM_UTF16_LE, "utf-16"), (codecs.BOM_UTF16_BE, "utf-16"))
_END_OF_FILE = "\x1a\x00"  # what DOS programs and loggers with files of a fixed size write after the last line
_NAMES = {"utf-8-sig": "UTF-8", "utf-16-le": "UTF-16", "utf-16-be": "UTF-16", "cp1252": "cp1252"}
_SHARE_OF_ZEROS = 0.3  # of the bytes of UTF-16 text in Latin letters and digits: half


def decode(data: bytes, encoding: str | None = None) -> tuple[str, str]:
    """Text and name of the encoding of ``data``; raises ``UnicodeError`` if it is no text in one of the four."""
    name = encoding or _encoding_of(data)
    text = data.decode(name).rstrip(_END_OF_FILE)
    if _CONTROL.search(text):
        raise UnicodeError("is no text file")
    return text, _NAMES.get(name, name.upper())


def _encoding_of(data: bytes) -> str:
    for mark, name in _BYTE_ORDER_MARKS:
        if data.startswith(mark):
            return name
    zeros = [data[start::2].count(0) for start in (0, 1)]
    if sum(zeros) > _SHARE_OF_ZEROS * len(data):
        return "utf-16-le" if zeros[1] > zeros[0] else "utf-16-be"
    for name in ("utf-8", "gb2312"):
        try:
            text = data.decode(name)
        except UnicodeDecodeError:
            continue
        if name == "utf-8" or _is_chinese(text):
            return {"gb2312": "gb18030"}.get(name, name)
    return "cp1252"


def _is_chinese(text: str) -> bool:
    """Whether text decoded from GB 2312 is Chinese: a single character between Latin letters is a misread umlaut."""
    found = _HANZI.findall(text)
    symbols = any(ord(character) > 0x7F for character in _HANZI.sub("", text))
    return all(len(run) > 1 for run in found) and (bool(found) or symbols)
