"""Drives that many tests share, and how Hypothesis runs here."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import settings

from cycloid_profile.design import DesignRecord, design_disc
from cycloid_profile.geometry import Cranks, Drive, InvoluteStage, ToothProfile, Trochoid
from cycloid_profile.spec import read_spec

# The suite must say the same twice: examples are drawn from a fixed seed. Hunt with
# ``--hypothesis-profile=explore``, which draws new ones each time.
settings.register_profile("repeatable", deadline=None, max_examples=25, derandomize=True)
settings.register_profile("explore", deadline=None, max_examples=300)
settings.load_profile("repeatable")


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_setupnodes() -> None:
    """One process a core: code that takes all cores in each of them only waits."""
    for threads in ("NUMBA_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
        os.environ.setdefault(threads, "1")


@pytest.fixture(scope="session")
def rv40e() -> Drive:
    """RV-40E as the tooth-profile article gives it; b = 11.5 mm and the bearing stiffness are assumed."""
    return Drive(Trochoid(40, 64.0, 1.3), 3.0, 11.5, 2, Cranks(3, 36.0, 4.0e5), InvoluteStage(12, 36, 1.5))


@pytest.fixture(scope="session")
def rv40e_ten() -> Drive:
    """RV-40E with a contact width of 10 mm, at which contact laws and pressures are compared."""
    return Drive(Trochoid(40, 64.0, 1.3), 3.0, 10.0, 2, Cranks(3, 36.0, 4.0e5), InvoluteStage(12, 36, 1.5))


@pytest.fixture(scope="session")
def theoretical(rv40e: Drive) -> ToothProfile:
    """The unmodified tooth of the RV-40E."""
    return rv40e.theoretical_profile


@pytest.fixture(scope="session")
def rated_torque() -> float:
    """Rated output torque of the RV-40E, 412 N·m [N·mm]."""
    return 412_000.0


@pytest.fixture(scope="session")
def rv40e_record() -> DesignRecord:
    """The whole design of examples/rv40e.toml."""
    return design_disc(read_spec(Path(__file__).parents[1] / "examples" / "rv40e.toml"))


@pytest.fixture(scope="session", autouse=True)
def own_record_of_files(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """The record of files made, which decides what may be replaced, is empty and out of the user's way."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_STATE_HOME", str(tmp_path_factory.mktemp("state")))
        yield
