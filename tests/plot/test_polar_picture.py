"""The picture of the polar program: drawn for any disc, and in the package only where its format is asked for."""

from __future__ import annotations

from dataclasses import replace

import msgspec
import numpy as np

from cycloid_profile.design import DesignRecord
from cycloid_profile.plot import pictures
from cycloid_profile.plot.design import polar_path
from cycloid_profile.plot.gallery import PICTURES


def asked(record: DesignRecord, **keys: object) -> DesignRecord:
    export = msgspec.structs.replace(record.spec.export, **keys)
    return replace(record, spec=msgspec.structs.replace(record.spec, export=export))


def test_picture_belongs_to_its_format(rv40e_record: DesignRecord) -> None:
    assert pictures(rv40e_record) == tuple(one for one in PICTURES[:-1] if not one.sliced)
    with_polar = pictures(asked(rv40e_record, formats=("csv", "gcode-polar")))
    assert [picture.name for picture in with_polar[-1:]] == ["polar_path"]


def test_picture_shows_path_feed_and_tangency(rv40e_record: DesignRecord) -> None:
    drawn = polar_path(asked(rv40e_record, chord_tolerance_um=1.0, wheel_radius_mm=2.5))
    wheel, path, feed, tangency = drawn.flat
    centre = next(line for line in wheel.lines if line.get_label() == "centre of the wheel")
    # Its wheels touch the tooth: the lowest centre lies one radius above the root at 59.7 mm less 6 µm.
    assert abs(np.min(np.hypot(*np.asarray(centre.get_data()))) - 59.694 - 2.5) < 1e-3
    c = np.asarray(path.lines[0].get_xdata())
    assert abs(c[-1] - c[0] - 3 * 360.0 / 39) < 1e-6
    contact = next(line for line in feed.lines if line.get_label() == "contact along the flank")
    assert np.allclose(np.asarray(contact.get_ydata()), 100.0)
    band = tangency.collections[0].get_paths()[0].vertices
    assert np.max(np.abs(band[:, 1])) <= 1.0
    assert all(axes.get_xlabel() and axes.get_ylabel() and axes.get_title() for axes in drawn.flat)
