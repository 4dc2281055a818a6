"""The spur pair of Kahraman and Singh (1991), docs/physics.md, section 9, as overrides."""

import math

__all__ = ["SPUR"]

SPUR = (
    "plane=omega_fpm",
    "plane.sweep.min=0.1",
    "plane.sweep.max=2.5",
    "plane.parameter.min=0.02",
    "plane.parameter.max=0.5",
    "gear=consistent",
    "gear.translation_coupling=0",
    "gear.rotation_coupling=1",
    "gear.variation.rotation=1",
    "gear.xi_mesh=0.05",
    "gear.alpha=0.2",
    f"gear.alpha_phase={math.pi}",
    f"gear.alpha_harmonics=[[0.1,{math.pi}],[0.05,{math.pi}]]",
    "gear.f_e=0.01",
    "gear.f_e_harmonics=[[0.004,0.0],[0.002,0.0]]",
)
