"""Maps of where a hidden item can be, after FuseBot [Boroushaki2023]."""
