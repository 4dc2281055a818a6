"""The benchmark of direct integration: its programs do the same, and it runs with and without heyoka."""

import builtins

import numpy as np
import pytest

from benchmarks import integrator
from solver.model.contact_system import gear_system
from tests.conftest import published


@pytest.mark.parametrize("system, omega", [(integrator.spur_pair(), 0.5), (gear_system(published()), 0.6)])
def test_programs_carry_motions_to_the_same_ends(system, omega):
    states = integrator.states_of(system)
    ends = [carry(system, omega, states, 3) for carry in (integrator.tables, integrator.stepwise)]
    np.testing.assert_allclose(*ends, atol=1e-6)


def test_it_says_that_heyoka_is_not_installed(monkeypatch, capsys):
    real = builtins.__import__

    def without(name, *arguments, **keywords):
        if name == "heyoka":
            raise ImportError(name)
        return real(name, *arguments, **keywords)

    monkeypatch.setattr(builtins, "__import__", without)
    monkeypatch.setattr(integrator, "PERIODS", 2)
    integrator.main()
    printed = capsys.readouterr().out
    assert "heyoka is not installed" in printed and printed.count("spur pair") == 3
