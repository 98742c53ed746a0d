"""Every effect that a plant may have: one class each, its parameters neutral unless given.

Each class says of itself, for programs that know no effect by name:

- `NAME`, `LAW`, `FIELDS` (name -> (unit, meaning));
- `HOOKS`, what it acts on: "force", "friction_level", "command_gain", "shape_command", "command_delay", "lag",
  "reading", "state". Where its law is a function, that is `force_at`, `friction_level_at`, `gain_at`, `shape_at`,
  `reading_at`, on scalars and arrays; `resolved(axis, cogging)` first fills in what it takes from the plant;
- `KINDS`, what parameters are together: `Wave` (a sine and a cosine with their period or frequency), `Window` (start
  and stop), `Knots` (levels at nodes), `SplineKnots` (even knots of lists of amplitudes), `Travel` (taken from the
  plant), `Place` (center and width of a stretch of the travel), `Turn` (a wave of exactly one turn, of rotary axes
  alone), each with the names of the fields;
- `ROLES`, name -> dict: `role` ("amplitude": the law is linear in it and vanishes at `neutral`; "shape": it is not;
  "setting": not to be searched for), `quantity` (what it is measured against), `low`, `high` (where to search, in
  multiples of that quantity's value), `logarithmic` (step in the logarithm), `neutral` (the value at which the effect
  does nothing, None where there is none).

The value of a quantity in a log: `force`, `command`: largest |command|; `friction`: the Coulomb level; `position`: a
place, 0 the lower and 1 the upper end of the travel; `distance`: length of the travel; `angle`: one turn, 2 pi;
`velocity`: largest speed; `time`: duration; `sample_time`; `frequency`: half the sample rate; `force_per_position`,
`force_per_velocity`, `force_per_velocity_squared`: quotients of these; `stiffness`: Coulomb level over length of the
travel; `relative`, `exponent`, `one`: 1; `absolute`: 1 in the parameter's own unit. A list has the role of each of its
values.

`Effect` is what all of them have in common; `Custom` makes one of your own.
"""

from cogging._core.effects import *  # noqa: F403  (the list stands in the core alone)
from cogging.effects.custom import Custom as Custom
from cogging.effects.effect import Effect as Effect
from cogging.effects.parameter import Parameter as Parameter
