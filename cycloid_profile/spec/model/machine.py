"""Keys of a machine file: control, axes, numbers, tool, heights, passes, and the blocks that a machine wants."""

from __future__ import annotations

from typing import Annotated, Literal

from msgspec import Meta

from cycloid_profile.spec.model.checks._table import Table, key
from cycloid_profile.spec.model.export import FEED, Dialect

Range = tuple[float, float]
Lines = tuple[Annotated[str, Meta(max_length=200, pattern=r"^[\x20-\x7e]*$")], ...]


def _lines(description: str) -> Meta:
    return key(description, "give a list of blocks in ASCII")


def _travel(axis: str) -> Meta:
    return key(f"Travel of {axis} from the work zero [mm].", "give the least and the greatest position")


class AxesSpec(Table, frozen=True, kw_only=True):
    """Travel, speed and acceleration of the axes."""

    x_mm: Annotated[Range, _travel("X")]
    y_mm: Annotated[Range, _travel("Y")]
    z_mm: Annotated[Range, _travel("Z")]
    c_speed_deg_per_s: Annotated[float, key("Maximum speed of C [°/s].", "give the axis limit", gt=0, le=1e6)]
    c_acceleration_deg_per_s2: Annotated[
        float, key("Largest acceleration of C [°/s²].", "give the axis limit", gt=0, le=1e7)
    ]
    x_speed_mm_per_min: Annotated[float, key("Maximum speed of X [mm/min].", "give the axis limit", **FEED)]
    x_acceleration_mm_per_s2: Annotated[
        float, key("Largest acceleration of X [mm/s²].", "give the axis limit", gt=0, le=1e6)
    ]


class NumbersSpec(Table, frozen=True, kw_only=True):
    """Numbers as the control keeps them; programs never hold more decimals, so that nothing is lost in reading."""

    decimals: Annotated[int, key("Decimals of lengths [mm].", "give what the control keeps, 3 to 6", ge=3, le=6)]
    angle_decimals: Annotated[int, key("Decimals of C [°].", "give what the control keeps, 3 to 7", ge=3, le=7)]
    feed_decimals: Annotated[int, key("Decimals of F.", "give what the control keeps, 0 to 6", ge=0, le=6)]
    feed_mm_per_min: Annotated[Range, key("Least and largest F in mm/min.", "give two numbers above zero")]
    inverse_time_per_min: Annotated[
        Range, key("Least and largest F with G93 [1/min]; unused at Heidenhain.", "give two numbers above zero")
    ]
    c: Annotated[
        Literal["incremental", "absolute"],
        key("How a turn is written: once in steps and repeated, or every turn with C rising.", ""),
    ]


class ToolSpec(Table, frozen=True, kw_only=True):
    """Grinding wheel or cutter in the tool table, and its spindle."""

    number: Annotated[int, key("Number of the tool.", "give 1 to 9999", ge=1, le=9999)]
    offset: Annotated[int, key("Number of its length and radius offset.", "give 1 to 999", ge=1, le=999)]
    spindle_rpm: Annotated[float, key("Speed of the spindle [1/min].", "give a speed", gt=0, le=1e6)]


class HeightsSpec(Table, frozen=True, kw_only=True):
    """Heights above the faces of the disc; Z is zero at its lower face."""

    safe_z_mm: Annotated[float, key("Safe height above the upper face [mm].", "give 5 to 100", ge=1, le=1000)]
    overrun_mm: Annotated[
        float, key("Overrun of the contour program below the lower face [mm].", "give 0 to 5", ge=0, le=100)
    ]


class PassesSpec(Table, frozen=True, kw_only=True):
    """Rough and finish passes; `[export.grinding]` of a spec overrides them."""

    stock_um: Annotated[float, key("Stock to grind off [µm].", "give the stock left for grinding", ge=0, le=5000)]
    infeed_um: Annotated[float, key("Infeed of every pass [µm].", "give 1 to 20 µm", gt=0, le=1000)]
    spark_out_turns: Annotated[int, key("Passes without infeed at the end.", "give 1 to 3", ge=0, le=100)]
    infeed_feed_mm_per_min: Annotated[float, key("Feed of the infeed along X [mm/min].", "give a slow feed", **FEED)]
    approach_feed_mm_per_min: Annotated[float, key("Feed in air [mm/min].", "give a feed", **FEED)]
    approach_gap_mm: Annotated[
        float, key("Gap in front of the stock at which the infeed begins [mm].", "give 0.05 to 1", ge=0.01, le=100)
    ]


class BlocksSpec(Table, frozen=True, kw_only=True):
    """Blocks at start and end, filled with {tool}, {offset}, {spindle} and {z}, the safe height."""

    contour: Annotated[Lines, _lines("Start of contour programs: plane, units, work offset.")]
    polar: Annotated[Lines, _lines("Start of polar programs.")]
    wire: Annotated[Lines, _lines("Start of wire programs.")]
    tool: Annotated[Lines, _lines("Tool call.")]
    spindle_on: Annotated[Lines, _lines("Spindle on.")]
    coolant_on: Annotated[Lines, _lines("Coolant on; empty for none.")]
    first_height: Annotated[Lines, _lines("Length offset and first move, to the safe height {z}.")]
    coolant_off: Annotated[Lines, _lines("Coolant off; empty for none.")]
    spindle_off: Annotated[Lines, _lines("Spindle off.")]
    thread: Annotated[Lines, _lines("Thread the wire.")]
    cut_wire: Annotated[Lines, _lines("Cut the wire.")]
    end: Annotated[Lines, _lines("End of every program.")]
    flush_on: Annotated[Lines, _lines("Flushing on, after the wire is threaded; empty for none.")] = ()
    flush_off: Annotated[Lines, _lines("Flushing off, before the wire is cut; empty for none.")] = ()
    accepted: Annotated[
        Lines, _lines("Further words in these blocks that the reader may pass over, such as `M48`.")
    ] = ()


class MachineSpec(Table, frozen=True, kw_only=True):
    """A whole machine file; keys that a file leaves out are those of the built-in file of its control."""

    name: Annotated[str, key("Name of the machine.", "give a short name", max_length=60, pattern=r"^[\x20-\x7e]*$")]
    control: Annotated[Dialect, key("Control of the machine.", "")]
    axes: AxesSpec
    numbers: NumbersSpec
    tool: ToolSpec
    heights: HeightsSpec
    passes: PassesSpec
    blocks: BlocksSpec
