"""Orders of a transmission error under their names, of an RV-40E: 39 lobes, 40 pins, 1560 meshes a turn."""

from __future__ import annotations

import numpy as np
import pytest

from cycloid_profile.rig import folded_order, order_label


@pytest.mark.parametrize(
    ("order", "poses", "label"),
    [
        (40, 3000, "40 = 40·1"),
        (78, 3000, "78 = 39·2"),
        (7, 3000, "7"),
        (1560, 5000, "1560 = mesh"),
        (3120, 7000, "3120 = 2·mesh"),
        # Every large order is a multiple of something.
        (1440, 3000, "1440 = mesh, folded"),
        (1400, 3000, "1400 = 40·35"),
        (240, 600, "240 = 40·6 or mesh, folded"),
        (60, 500, "60 = mesh, folded"),
        (80, 3200, "80 = 40·2 or 2·mesh, folded"),
        # The third harmonic folds there as well.
        (120, 600, "120 = 40·3 or 2·mesh, folded"),
    ],
)
def test_orders_are_named(order: int, poses: int, label: str) -> None:
    assert order_label(order, 39, 40, poses) == label


def test_the_mesh_folds_more_than_once() -> None:
    assert [folded_order(1560, n) for n in (5000, 3000, 1200, 600, 500)] == [1560, 1440, 360, 240, 60]


@pytest.mark.parametrize("poses", [499, 500, 601, 1200, 3200])
@pytest.mark.parametrize("order", [40, 1560, 3120, 4680])
def test_an_order_shows_where_the_spectrum_has_it(order: int, poses: int) -> None:
    wave = np.cos(2.0 * np.pi * order * np.arange(poses) / poses)
    assert int(np.argmax(np.abs(np.fft.rfft(wave)))) == folded_order(order, poses)
