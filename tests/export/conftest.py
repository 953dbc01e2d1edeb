"""A disc of few lobes, whose files and programs are short."""

from __future__ import annotations

from dataclasses import replace

import pytest

from cycloid_profile.design import DesignRecord
from cycloid_profile.geometry import CentralEccentric, DiscOutline, Drive, ToothProfile, Trochoid


@pytest.fixture(scope="session")
def eleven_lobes(rv40e_record: DesignRecord) -> DesignRecord:
    """The design of the RV-40E with a tooth of eleven lobes and no openings, of the same width."""
    tooth = ToothProfile(Trochoid(12, 64.0, 4.0), 10.0)
    drive = Drive(tooth.trochoid, 5.0, rv40e_record.drive.disc_width, 2, CentralEccentric(4e5))
    return replace(rv40e_record, drive=drive, profile=tooth, outline=DiscOutline(tooth, ()))
