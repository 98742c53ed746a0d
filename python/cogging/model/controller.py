"""Protocols of controllers: a user's own, and those of the core."""

from __future__ import annotations

from typing import Any, ClassVar, NamedTuple, Protocol, runtime_checkable

from cogging.arrays import FloatArray


class ReferencePoint(NamedTuple):
    """Reference of one sample.

    Attributes:
        position: m.
        velocity: m/s.
        acceleration: m/s^2.
    """

    position: float
    velocity: float
    acceleration: float

    def __repr__(self) -> str:
        return f"ReferencePoint({self.position:.6g} m, {self.velocity:.6g} m/s, {self.acceleration:.6g} m/s^2)"


@runtime_checkable
class Controller(Protocol):
    """A user's controller: any object with a sample rate and a command.

    `simulate(model, reference, controller=mine)`, `closed_loop`, `closed_loop_batch`, `replay_controller` and
    `predict_error` accept it like a controller of the core. A run is a pure function: it works on a deep copy
    (`copy.deepcopy`), so that state belongs in the object and not in globals.

    Every sample calls `command`, then `update` if it exists. Optional members:

    - `update(applied: float) -> None`: ends the sample; the command (V) that was applied, cut at the limit;
    - `reset() -> None`: called on the copy before the run;
    - `command_limit: float`: V, largest command; 0 = none;
    - `estimates`: numbers that `record_estimates` records, one row a sample, always as many.

    Attributes:
        sample_rate: Hz.
    """

    @property
    def sample_rate(self) -> float: ...  # noqa: D102

    def command(self, reference: ReferencePoint, reading: float) -> float:
        """Return the command of this sample, V, a finite number.

        Args:
            reference: position (m), velocity (m/s) and acceleration (m/s^2).
            reading: of the encoder, m.
        """
        ...


class ListedController(Protocol):
    """A controller of the core, which model files name (`cogging.CONTROLLERS`)."""

    NAME: ClassVar[str]

    @property
    def parameters(self) -> Any:
        """Parameter struct."""

    @property
    def sample_rate(self) -> float:
        """Hz."""

    @property
    def estimates(self) -> FloatArray:
        """Present estimates, (p,)."""

    def update(self, applied: float) -> None:
        """End the sample with the command (V) that was applied."""


class ControllerParameters(Protocol):
    """Parameters of a controller of the core: read-only fields, those named here and its own."""

    FIELDS: ClassVar[dict[Any, Any]]

    @property
    def sample_rate(self) -> float:
        """Hz."""

    @property
    def command_limit(self) -> float:
        """V; 0 = none."""

    def replace(self, **changes: Any) -> Any:
        """Return a copy with the given fields changed."""

    def to_dict(self) -> dict[str, Any]:
        """Return all fields by name."""


#: A controller of the core, or any object that is a Controller.
AnyController = Controller | ListedController
