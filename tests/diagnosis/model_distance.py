"""How much reasonable models of one reducer differ: files of the generator under other laws, less those under Roark's.

``python -m tests.diagnosis.model_distance`` prints the table of docs/diagnosis-validation.md: root mean square of the
difference in the unit of each file, with the mean removed where a measurement does not know it.
"""

from __future__ import annotations

import argparse

import numpy as np

from tests.diagnosis.blind import REDUCERS, Body, Law, PowerLaw, Reducer, ReferenceDepth, Roark
from tests.diagnosis.blind.contact import at_rated
from tests.diagnosis.separable import View

FILES = ("te", "te_light", "lost_motion", "loop")


def forms(reducer: Reducer) -> dict[str, tuple[Law, Body]]:
    """Laws and bodies to compare, the elastic ones in shares of the compliance of the contact."""
    load, approach = at_rated(reducer)
    stiff, soft = (Body(share * approach / load, 2.0) for share in (0.05, 0.25))
    return {
        "power law, 10/9": (PowerLaw(10.0 / 9.0), Body()),
        "linear spring": (PowerLaw(1.0), Body()),
        "Hertz, depth of 3 mm": (ReferenceDepth(3.0), Body()),
        "Hertz, depth of 15 mm": (ReferenceDepth(15.0), Body()),
        "elastic disc, 5 % of the contact": (Roark(), stiff),
        "elastic disc, 25 % of the contact": (Roark(), soft),
    }


def distances(reducer: Reducer, contact: Law, body: Body) -> list[float]:
    """Root mean square of the difference in each of ``FILES``."""
    angle = 33.0
    here = View(FILES, reducer, angle, contact=contact, body=body).columns([])
    there = View(FILES, reducer, angle).columns([])
    left = [here[name] - there[name] for name in FILES]
    known = [
        column if name == "lost_motion" else column - np.mean(column) for name, column in zip(FILES, left, strict=True)
    ]
    return [float(np.sqrt(np.mean(column**2))) for column in known]


def main() -> None:
    argparse.ArgumentParser(description=__doc__).parse_args()
    print("| drive | form | error at rated torque ″ | at 3 % ″ | lost motion at 3 % ′ | loop ′ |")
    print("|---" * 6 + "|")
    for drive, reducer in REDUCERS.items():
        for name, (contact, body) in forms(reducer).items():
            print(f"| {drive} | {name} | " + " | ".join(f"{v:.2g}" for v in distances(reducer, contact, body)) + " |")


if __name__ == "__main__":
    main()
