"""The constants of a model file as a C++ header: the controller, and the axis that stands in for the machine.

python generate.py MODEL.toml --out controller_constants.hpp
"""

import argparse
import math
import sys
from pathlib import Path

import numpy as np

import cogging

#: Header and class of each type of controller.
CLASSES = {
    "pid": ("pid", "Pid"),
    "cascade": ("cascade", "Cascade"),
    "speed": ("speed", "Speed"),
    "arc": ("adaptive_robust", "Arc"),
    "dcarc": ("adaptive_robust", "Dcarc"),
    "output_feedback_arc": ("output_feedback_adaptive_robust", "OutputFeedbackArc"),
    "observer_based": ("observer_based", "ObserverBased"),
}

HEADER = """// Generated from {source} by generate.py: change the model and generate again.
#pragma once

#include <limits>

#include "cogging/control/{header}.hpp"
#include "cogging/plant/plant.hpp"

namespace constants {{

using Controller = cogging::{name}<>;

inline Controller::Parameters controller() {{
  Controller::Parameters q;
{controller}
  return q;
}}

/// The machine as the model has it, for a loop without one.
inline cogging::Plant<> plant() {{
  cogging::Plant<> p;
{plant}
  return p;
}}

}}  // namespace constants
"""


def literal(value):
    """A value as C++ writes it; a double reads back as the same number."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return f'"{value}"'
    if isinstance(value, (list, tuple)):
        return "{" + ", ".join(literal(one) for one in value) + "}"
    if isinstance(value, float) and math.isinf(value):
        return ("-" if value < 0 else "") + "std::numeric_limits<double>::infinity()"
    return repr(value)


def assignments(target, fields):
    """One line for each field of a parameter struct."""
    return [f"  {target}.{name} = {literal(value)};" for name, value in fields.items()]


def cogging_lines(model):
    """The cogging as the basis and its coefficients, one row a control point."""
    spline = model.basis.spline
    coefficients = np.stack([model.sine.T, model.cosine.T], axis=-1).ravel().tolist()
    numbers = [spline.order, spline.origin, spline.pitch, spline.control_points]
    made = f"cogging::BSpline({', '.join(map(literal, numbers))})"
    if model.basis.harmonics:
        basis = f"of_harmonics({literal(model.basis.pitch)}, {literal(list(model.basis.harmonics))}, {made})"
    else:
        basis = f"of_periods({literal(list(model.basis.periods))}, {made})"
    return [
        f"  const auto basis = cogging::SplineHarmonics::{basis};",
        f"  p.cogging = cogging::CoggingModel<>(basis, {literal(coefficients)});",
    ]


def header(model, source):
    """The header's text."""
    if model.controller is None:
        raise cogging.InputError(f"{source}: controller: must be there, got a model without one")
    if model.effects:
        raise cogging.InputError(
            f"{source}: effects: must be left out, got {model.effects[0].NAME}: the axis here has none"
        )
    name = CLASSES[model.controller_type]
    plant = assignments("p.axis", model.axis.to_dict()) + assignments("p.encoder", model.encoder.to_dict())
    if model.cogging is not None:
        plant += cogging_lines(model.cogging)
    return HEADER.format(
        source=source,
        header=name[0],
        name=name[1],
        controller="\n".join(assignments("q", model.controller.to_dict())),
        plant="\n".join(plant),
    )


def main():
    """Write the header; 2 where the model cannot be used."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("model", type=Path, metavar="MODEL.toml")
    parser.add_argument("--out", type=Path, required=True, metavar="HEADER.hpp")
    options = parser.parse_args()
    try:
        options.out.write_text(header(cogging.Model.read(options.model), options.model.name), encoding="utf-8")
    except (cogging.InputError, OSError) as error:
        print(f"generate.py: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
