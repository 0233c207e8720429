"""Robot, part and tag-layout descriptions, as data files. Only `rfcompass.robots` loads them."""
