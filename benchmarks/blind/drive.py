"""Two drives: a chain of inertias with a motor, by hand-written equations, and the models that are handed over.

The seed's drive (H. H. van de Ven, "Aspects of dynamic models of robots", Journal A 27(1), 1986, section 4.1) is
tachometer, motor, harmonic drive and load on three shafts; the other is a motor and a load that the model takes for
rigid. The servo records what it samples: its voltage as commanded, ahead of the amplifier; current, the motor's angle
and the tachometer's voltage always; the angle of the output in every other case.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from benchmarks.blind import laws
from benchmarks.blind.chain import AMPLIFIER, SHAFT, SUPPLY, simulate
from benchmarks.blind.machine import Machine, Place, Recorded, effect_table, parameter_lines
from benchmarks.blind.motions import CONTROL, multisine
from benchmarks.blind.planting import Planted, rows
from benchmarks.blind.sensors import LEVELS, TACHO_CONSTANT, analogue, encoder, faulty

STEPS = 50  # of the integration per control sample: the poles of the chain are below 20 000 1/s
DURATION = 10.0  # s
REACH = 4.0  # rad, of the motor
CURRENT, TACHO = 4.0, 1.0  # A, V: full ranges
DITHER = 1.0  # V: a random step every 20 ms, so that more than slow motion is excited
CHANNELS = {  # what a column of the recording measures, and where
    "u": ("voltage", "j1", "V"),
    "i": ("current", "j1", "A"),
    "x": ("position", "j1.motor", "rad"),
    "w": ("voltage", "{tacho}", "V"),
    "z": ("position", "j1", "rad"),
}


class Drive(Machine):
    """What both drives share: ``inertias``, ``shafts`` (stiffness, damping) and friction name the true parameters."""

    inertias: tuple[str, ...]
    shafts: tuple[tuple[str, str], ...]
    friction: tuple[tuple[str | None, str | None], ...]  # viscous, Coulomb, of each inertia
    motor: int  # which inertia
    tacho: int
    flexible: str  # the address of the last shaft

    def record(
        self, planted: tuple[Planted, ...], true: Mapping[str, float], run: int, level: str, seed: int
    ) -> Recorded:
        rng = self.rng(planted, run, level, seed)
        true = {**true, **self.plant_of(planted, self.flexible)}
        reference, speeds = multisine(rng, run, DURATION, np.zeros(1), np.array([REACH]))
        own: list[dict[str, float]] = []
        for drag, dry in self.friction:
            value = true[dry] if dry else 0.0
            own.append({"viscous": true[drag] if drag else 0.0, "level_positive": value, "level_negative": value})
        p = rows(planted, self.places, own)
        if "stiffness" in true:  # a compliance that was planted
            true["c"] = true["stiffness"]
        chain = np.array([true[name] for name in self.inertias]) + p[:, laws.ADDED_INERTIA]
        springs = np.array([[true[c], true[d]] for c, d in self.shafts])
        last = np.array([true.get(name, 0.0) for name in SHAFT])
        stages = {"amplifier_limit": SUPPLY, **self.plant_of(planted, "j1.circuit")}
        amplifier = np.array([stages.get(name, 0.0) for name in AMPLIFIER])
        motor = np.array([true["R"], true["L"], true["K_T"], true["K_E"]])
        sensors = LEVELS[level]
        noise = sensors.encoder_noise * rng.standard_normal(len(reference))
        dither = np.repeat(rng.choice((-DITHER, DITHER), len(reference) // 20 + 1), 20)[: len(reference)]
        u, current, angle, speed, load = simulate(
            chain,
            springs,
            last,
            amplifier,
            motor,
            p,
            self.motor,
            self.tacho,
            reference[:, 0],
            speeds[:, 0],
            dither,
            noise,
            sensors.stride,
            STEPS,
        )
        every = slice(None, None, sensors.stride)
        angle = faulty(angle, self.fault_of(planted, f"{self.places[self.motor].address}.position"))
        current = faulty(current, self.fault_of(planted, "current"))
        volts = faulty(TACHO_CONSTANT * speed, self.fault_of(planted, "tacho"))
        columns = {
            "u": u[every],
            "i": analogue(current[every], CURRENT, sensors, rng),
            "x": encoder(angle[every], sensors),
            "w": analogue(volts[every], TACHO, sensors, rng),
            "z": encoder(load[every] + sensors.encoder_noise * rng.standard_normal(len(load))[every], sensors),
        }
        return Recorded.even(CONTROL * sensors.stride, {name: columns[name] for name in self.shown(seed)})

    @staticmethod
    def shown(seed: int) -> str:
        """Which columns there are: that of the output encoder in every other case, the others always."""
        return "uixw" if seed % 2 else "uixwz"

    def channel_text(self, seed: int) -> str:
        """The [recording] table."""
        text = '\n[recording]\ntime = { column = "t", unit = "s" }\n'
        for column in self.shown(seed):
            quantity, place, unit = CHANNELS[column]
            place = place.format(tacho=self.places[self.tacho].address)
            text += f'\n[[recording.channel]]\ncolumn = "{column}"\nquantity = "{quantity}"\n'
            text += f'joint = "{place}"\nunit = "{unit}"\n'
        return text

    def tacho_text(self, planted: Sequence[Planted], form: bool) -> str:
        """The tachometer of the model, where what was planted does not bring its own."""
        if form and any(plant.kind == "tacho_lag" for plant in planted):
            return ""
        place = self.places[self.tacho].address
        return f'\n[[effect]]\ntype = "tachometer"\nat = "{place}"\nconstant = "{TACHO_CONSTANT} V s/rad"\n'

    def friction_text(self, gone: set[str]) -> tuple[str, set[str]]:
        """[[effect]] tables of the machine's own friction, and the parameters that are not needed then."""
        text, spare = "", set()
        moving = [place.address for place in self.places if place.kind in ("joint", "inertia")]
        for address, (drag, dry) in zip(moving, self.friction, strict=True):
            for letter, kind, effect, name in (
                (drag, "viscous", "viscous_friction", "coefficient"),
                (dry, "dry", "coulomb_friction", "level"),
            ):
                if letter is None:
                    continue
                if f"{kind} {address}" in gone:
                    spare.add(letter)
                    continue
                text += effect_table(effect, address, {name: f'"{letter}"'})
        return text, spare


SEED_TRUTH = {
    "R": (1.6, "Ohm"), "L": (87e-6, "H"), "K_T": (0.088, "N m/A"), "K_E": (0.088, "V s/rad"), "T_f": (0.025, "N m"),
    "J_1": (34e-6, "kg m^2"), "J_2": (41e-6, "kg m^2"), "J_3": (196e-6, "kg m^2"), "J_4": (372e-6, "kg m^2"),
    "d_1": (1.2e-3, "N m s/rad"), "d_2": (0.068, "N m s/rad"), "d_3": (1.6e-3, "N m s/rad"),
    "d_4": (76e-6, "N m s/rad"), "d_5": (12e-6, "N m s/rad"), "d_6": (700e-6, "N m s/rad"),
    "c_1": (789.0, "N m/rad"), "c_2": (1225.0, "N m/rad"), "c_3": (1.44, "N m/rad"),
}  # fmt: skip

SEED_MODEL = """[robot]
name = "machine"
gravity = [0, 0, 0]

[parameters]
{parameters}

[dh]
rows = [ [ "q", 0, 0, 0 ] ]

[[joint]]
name = "j1"
link = {{ inertia = {{ about = "joint", zz = "J_4" }} }}

[joint.drive]
ratio = 1
rotors = [
  {{ name = "tacho", inertia = "J_1" }},
  {{ name = "motor", inertia = "J_2" }},
  {{ name = "gear", inertia = "J_3" }},
]
shafts = [
  {{ name = "shaft1", from = "tacho", to = "motor", stiffness = "c_1", damping = "d_1" }},
  {{ name = "shaft2", from = "motor", to = "gear", stiffness = "c_2", damping = "d_2" }},
  {{ name = "shaft3", from = "gear", to = "joint", stiffness = "c_3", damping = "d_3" }},
]

[joint.drive.motor]
name = "circuit"
at = "motor"
resistance = "R"
inductance = "L"
torque_constant = "K_T"
back_emf_constant = "K_E"
"""


class SeedDrive(Drive):
    name = "seed-drive"
    truth = SEED_TRUTH
    inertias, shafts = ("J_1", "J_2", "J_3", "J_4"), (("c_1", "d_1"), ("c_2", "d_2"), ("c_3", "d_3"))
    friction = (("d_4", None), ("d_5", "T_f"), ("d_6", None), (None, None))
    motor, tacho, flexible = 1, 0, "j1.shaft3"
    places = (
        Place("j1.tacho", "inertia", 0.02, 12.0, REACH),
        Place("j1.motor", "inertia", 0.03, 12.0, REACH),
        Place("j1.gear", "inertia", 0.03, 12.0, REACH),
        Place("j1", "joint", 0.03, 12.0, REACH),
        Place("j1.shaft3", "shaft", 0.03, 1.0, 0.03),
        Place("j1.circuit", "circuit", 1.0, 0.0, 0.0),
    )

    def model(self, given: Mapping[str, float], planted: tuple[Planted, ...], seed: int, form: bool = False) -> str:
        gone = {part for plant in planted for part in plant.omitted}
        friction, spare = self.friction_text(gone)
        text = SEED_MODEL.format(parameters=parameter_lines(self.truth, given, spare))
        text += friction + self.tacho_text(planted, form) + self.form_text(planted, form)
        return text + self.channel_text(seed)


RIGID_TRUTH = {
    "R": (1.6, "Ohm"), "L": (0.4e-3, "H"), "K_T": (0.088, "N m/A"), "K_E": (0.088, "V s/rad"), "T_f": (0.02, "N m"),
    "J_m": (90e-6, "kg m^2"), "J_l": (350e-6, "kg m^2"), "b": (300e-6, "N m s/rad"),
}  # fmt: skip

RIGID_MODEL = """[robot]
name = "machine"
gravity = [0, 0, 0]

[parameters]
{parameters}

[dh]
rows = [ [ "q", 0, 0, 0 ] ]

[[joint]]
name = "j1"
link = {{ inertia = {{ about = "joint", zz = "J_l" }} }}

[joint.drive]
ratio = 1
rotors = [ {{ name = "motor", inertia = "J_m", fixed_to_joint = true }} ]

[joint.drive.motor]
name = "circuit"
at = "motor"
resistance = "R"
inductance = "L"
torque_constant = "K_T"
back_emf_constant = "K_E"
"""
STIFF = {"c": 4000.0, "d": 0.6}  # N m/rad: rigid, as far as any sensor here can tell


class RigidDrive(Drive):
    """The shaft is there in the plant, stiff but for the cases in which it is what the model lacks."""

    name = "rigid-drive"
    truth = RIGID_TRUTH
    inertias, shafts = ("J_m", "J_l"), (("c", "d"),)
    friction = (("b", "T_f"), (None, None))
    motor, tacho, flexible = 0, 0, "j1.shaft"
    places = (
        Place("j1.motor", "inertia", 0.03, 12.0, REACH, same_as=("j1",)),
        Place("j1", "joint", 0.03, 12.0, REACH),
        Place("j1.shaft", "missing shaft", 0.03, 1.0, 0.03),
        Place("j1.circuit", "circuit", 1.0, 0.0, 0.0),
    )

    def record(
        self, planted: tuple[Planted, ...], true: Mapping[str, float], run: int, level: str, seed: int
    ) -> Recorded:
        flexible = bool(self.plant_of(planted, self.flexible))
        return super().record(planted, {**true, **STIFF, **({"d": 1e-3} if flexible else {})}, run, level, seed)

    def model(self, given: Mapping[str, float], planted: tuple[Planted, ...], seed: int, form: bool = False) -> str:
        gone = {part for plant in planted for part in plant.omitted}
        friction, spare = self.friction_text(gone)
        text = RIGID_MODEL.format(parameters=parameter_lines(self.truth, given, spare))
        text += friction + self.tacho_text(planted, form) + self.form_text(planted, form)
        return text + self.channel_text(seed)
