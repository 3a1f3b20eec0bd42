"""Numbers that decide the structure of a model stand in its file as themselves: no kernel could change them."""

from __future__ import annotations

from symdyn.spec.findings import Findings
from symdyn.spec.records import Monomial
from symdyn.spec.toml_positions import KeyPath


def check_count(name: str, monomial: Monomial, value: float, path: KeyPath, findings: Findings) -> None:
    """Refuse (SD202) what is no whole number, or a parameter."""
    if monomial.factors or value != int(value):
        findings.error(path, "SD202", f"{name} must be a whole number, not a parameter")


def check_zero(name: str, monomial: Monomial, value: float | None, path: KeyPath, findings: Findings) -> None:
    """Refuse (SD203) a parameter of value zero where zero takes a state out of the model."""
    if monomial.factors and value == 0:
        message = f"{name} is a parameter of value 0, and without it a state is gone"
        findings.error(path, "SD203", message, "write 0 itself, or leave it out")
