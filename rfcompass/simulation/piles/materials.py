"""What items are made of, and what that does to a wave at 915 MHz.

A wave loses α = 8.686 π f √ε tan δ / c dB for each metre inside, and what two faces reflect at normal incidence,
-20 log10(4 √ε / (1 + √ε)²), in each passage. Water's ε = 80 and tan δ = 0.05 follow from Debye's formula at 20 degrees
(static permittivity 80.1, 9.4 ps) [Kaatze1989]; the other permittivities are typical values of their kind, ours.
"""

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np

from rfcompass.types.scene import Material

_F_HZ, _C_M_S = 915e6, 299_792_458.0
# Name: relative permittivity, loss tangent, density of an item of it [kg/m³]. Densities are those of whole items, air
# inside included; ours.
_STUFFS = {
    "cloth": (1.6, 0.02, 180.0),
    "foam": (1.1, 0.002, 60.0),
    "plastic": (2.4, 0.005, 250.0),
    "card": (1.8, 0.05, 200.0),
    "liquid": (80.0, 0.05, 900.0),
    "metal": (1.0, 0.0, 900.0),
}
# A tag on these does not answer: they short it, or detune it and take its power.
UNTAGGED = ("liquid", "metal")
# A closed can lets nothing through; what arrives went round it, which nobody computes here. Ours.
_METAL_DB = 30.0


def _material(name: str, permittivity: float, loss_tangent: float) -> Material:
    if name == "metal":
        return Material(name, surface_loss_db=_METAL_DB, conductor=True)
    n = np.sqrt(permittivity)
    loss_db_per_m = 20 * np.log10(np.e) * np.pi * _F_HZ * n * loss_tangent / _C_M_S
    return Material(name, permittivity, float(loss_db_per_m), float(-20 * np.log10(4 * n / (1 + n) ** 2)))


PILE_MATERIALS: Mapping[str, Material] = MappingProxyType(
    {name: _material(name, *numbers[:2]) for name, numbers in _STUFFS.items()}
)
DENSITY_KG_M3: Mapping[str, float] = MappingProxyType({name: numbers[2] for name, numbers in _STUFFS.items()})
