"""Effects of a plant: one class each, with neutral parameters by default.

Each class describes itself, for programs that know no effect by name:

- `NAME`, `LAW`, `FIELDS` (name -> (unit, meaning));
- `HOOKS`, the quantities it acts on: "force", "friction_level", "command_gain", "shape_command", "command_delay",
  "lag", "reading", "state". Laws that are functions are `force_at`, `friction_level_at`, `gain_at`, `shape_at`,
  `reading_at`, on scalars and arrays; `resolved(axis, cogging)` first fills in fields that come from the plant;
- `KINDS`, groups of parameters, each with the names of its fields: `Wave` (a sine and a cosine with their period or
  frequency), `Window` (start and stop), `Knots` (levels at nodes), `SplineKnots` (even knots of lists of amplitudes),
  `Travel` (from the plant), `Place` (center and width of a part of the travel), `Turn` (a wave of exactly one turn, on
  rotary axes only);
- `ROLES`, name -> dict: `role` ("amplitude": the law is linear in it and vanishes at `neutral`; "shape": it is not
  linear; "setting": not searched for), `quantity` (reference of the range), `low`, `high` (range of the search in
  multiples of the quantity), `logarithmic` (search in the logarithm), `neutral` (value at which the effect vanishes,
  or None).

The value of a quantity in a log: `force`, `command`: largest |command|; `friction`: the Coulomb level; `position`: a
place, 0 the lower and 1 the upper end of the travel; `distance`: length of the travel; `angle`: one turn, 2 pi;
`velocity`: largest speed; `time`: duration; `sample_time`; `frequency`: half the sample rate; `force_per_position`,
`force_per_velocity`, `force_per_velocity_squared`: quotients of these; `stiffness`: Coulomb level over length of the
travel; `relative`, `exponent`, `one`: 1; `absolute`: 1 in the parameter's own unit. A list has the role of each of its
values.

`Effect` is their common interface; `Custom` defines an effect of your own.
"""

from cogging._core.effects import *  # noqa: F403  (the list stands in the core alone)
from cogging.effects.custom import Custom as Custom
from cogging.effects.custom import Parameter as Parameter
from cogging.effects.effect import Effect as Effect
