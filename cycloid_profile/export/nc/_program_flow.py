"""Lines of a program in the order of running: subprograms, repeated sections and labels of four controls."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator

from cycloid_profile.errors import ExportError

Line = tuple[int, str]  # number and text
Refuse = Callable[[int, str, str], ExportError]  # the error of a line with its number, a word of it and the finding


def o_words(lines: list[Line], refuse: Refuse) -> Iterator[Line]:
    """Lines of a LinuxCNC program in the order of running."""
    subs: dict[str, list[Line]] = {}
    main: list[Line] = []
    into: list[Line] | None = None
    for number, text in lines:
        word = re.fullmatch(r"o(\d+) (sub|endsub|call)", text)
        if word and word[2] == "sub":
            into = subs.setdefault(word[1], [])
        elif word and word[2] == "endsub":
            into = None
        elif word:
            main += subs[word[1]]
        elif text == "%":
            if number not in (1, lines[-1][0]):
                raise refuse(number, text, "stands inside the program")
        else:
            (main if into is None else into).append((number, text))
    return iter(main)


def o_programs(lines: list[Line], refuse: Refuse) -> Iterator[Line]:
    """Lines of a Fanuc program and of its subprograms in the order of running."""
    programs: dict[int, list[Line]] = {}
    for number, text in lines:
        if re.fullmatch(r"O\d{4}", text):
            programs[int(text[1:])] = []
        elif text == "%":
            if number not in (1, lines[-1][0]):
                raise refuse(number, text, "stands inside the program")
        elif not programs:
            raise refuse(number, text, "stands before the number of the program")
        else:
            programs[list(programs)[-1]].append((number, text))
    for number, text in next(iter(programs.values())):
        call = re.fullmatch(r"M98 P(\d{4})", text)
        if call is None:
            yield number, text
            continue
        body = programs.get(int(call[1]), [])
        if not body or body[-1][1] != "M99":
            raise refuse(number, text, "calls a subprogram without M99")
        yield from body[:-1]


def sections(lines: list[Line], refuse: Refuse) -> Iterator[Line]:
    """Lines of a Siemens program in the order of running."""
    label = {text[:-1]: i for i, (_, text) in enumerate(lines) if re.fullmatch(r"[A-Z_]+:", text)}
    i = 0
    while i < len(lines):
        number, text = lines[i]
        jump = re.fullmatch(r"GOTOF (\w+)", text)
        again = re.fullmatch(r"REPEAT (\w+) (\w+) P=(\d+)", text)
        if jump or again:
            names = [jump[1]] if jump else [again[1], again[2]]  # type: ignore[index]
            if not all(name in label for name in names):
                raise refuse(number, text, "names an absent label")
        if jump:
            i = label[jump[1]]
        elif again:
            for _ in range(int(again[3])):
                yield from lines[label[again[1]] + 1 : label[again[2]]]
        elif not (i == 0 and re.fullmatch(r"%_N_\w+_MPF", text)) and not re.fullmatch(r"[A-Z_]+:", text):
            yield number, text
        i += 1


def klartext_blocks(lines: list[Line], refuse: Refuse) -> Iterator[Line]:
    """Blocks of a klartext program without their numbers, labels called, in the order of running."""
    blocks: list[Line] = []
    for number, text in lines:
        if blocks and blocks[-1][1].endswith("~"):
            blocks[-1] = (blocks[-1][0], f"{blocks[-1][1]} {text.strip()}")
            continue
        head, _, block = text.partition(" ")
        if head != str(len(blocks)):
            raise refuse(number, text, "has a wrong block number")
        blocks.append((number, block))
    begin, end = blocks[0], blocks.pop()
    if not re.fullmatch(r"BEGIN PGM \w+ MM", begin[1]) or end[1] != begin[1].replace("BEGIN", "END"):
        raise refuse(begin[0], begin[1], "does not begin and end one program in mm")
    labels = {text[4:]: i for i, (_, text) in enumerate(blocks) if re.fullmatch(r"LBL [1-9]\d*", text)}
    for number, text in blocks[1:]:
        call = re.fullmatch(r"CALL LBL (\d+)", text)
        if call is None:
            yield number, text
            if re.match(r"M(?:2|30)\b", text):
                return  # labels follow
            continue
        if call[1] not in labels:
            raise refuse(number, text, "names an absent label")
        for inner in blocks[labels[call[1]] + 1 :]:
            if inner[1] == "LBL 0":
                break
            yield inner
