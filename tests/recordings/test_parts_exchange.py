"""Files of parts: what was written comes back, and what is wrong is named by file and key."""

import json
import stat

import pytest
from hypothesis import given, settings
from part_strategies import same, some_parts

from rfcompass.errors import DuplicateEpc, InputError, PartError
from rfcompass.recordings.parts import PartCollection, read_parts, write_parts
from rfcompass.recordings.parts.exchange import SCHEMA, collection_text, parse_collection
from rfcompass.recordings.parts.lack import lack_table
from rfcompass.types.parts import Assembly


@settings(max_examples=20)
@given(some_parts())
def test_what_was_written_comes_back(some):
    product = (Assembly("product", tuple(part.part_id for part in some)),) if some else ()
    collection = PartCollection(some, product)
    copy = parse_collection(collection_text(collection), "parts.json")
    assert copy.assemblies == collection.assemblies
    assert len(copy.parts) == len(collection.parts)
    assert all(same(a, b) for a, b in zip(copy.parts, collection.parts, strict=True))


def test_equal_collections_give_equal_text():
    assert collection_text(lack_table()) == collection_text(parse_collection(collection_text(lack_table()), "f"))


def test_the_text_keeps_the_numbers_of_a_vector_on_one_line():
    assert '"size_m": [0.4, 0.05, 0.05]' in collection_text(lack_table())


def a_document():
    return json.loads(collection_text(lack_table()))


DELETED = object()


def with_change(document, way, value):
    place = document
    for step in way[:-1]:
        place = place[step]
    if value is DELETED:
        del place[way[-1]]
    else:
        place[way[-1]] = value
    return json.dumps(document)


LEG = ("parts", 2)


@pytest.mark.parametrize(
    ("way", "value", "key"),
    [
        (("schema",), "rfcompass-parts/2", "schema"),
        (("schema",), DELETED, "schema"),
        (("parts",), DELETED, "parts"),
        (("parts",), {}, "parts"),
        (("extra",), 1, "extra"),
        ((*LEG,), [], "parts[2]"),
        ((*LEG, "id"), DELETED, "parts[2].id"),
        ((*LEG, "id"), 7, "parts[2].id"),
        ((*LEG, "id"), "a b", "parts[2]"),
        ((*LEG, "grasp_width"), 0.05, "parts[2].grasp_width"),
        ((*LEG, "mass_kg"), "1", "parts[2].mass_kg"),
        ((*LEG, "mass_kg"), True, "parts[2].mass_kg"),
        ((*LEG, "mass_kg"), 10**400, "parts[2].mass_kg"),
        ((*LEG, "mass_kg"), -1, "parts[2]"),
        ((*LEG, "rigid"), 1, "parts[2].rigid"),
        ((*LEG, "inertia_kg_m2"), [[1, 0], [0, 1, 0]], "parts[2].inertia_kg_m2"),
        ((*LEG, "shape"), {}, "parts[2].shape.kind"),
        ((*LEG, "shape", "kind"), "teapot", "parts[2].shape.kind"),
        ((*LEG, "shape", "size_m"), [0.4, -0.05, 0.05], "parts[2].shape"),
        ((*LEG, "shape", "size_m", 1), None, "parts[2].shape.size_m[1]"),
        ((*LEG, "shape"), {"kind": "mesh"}, "parts[2].shape.vertices_m"),
        ((*LEG, "tags", 0, "epc"), "12", "parts[2]"),
        ((*LEG, "tags", 0, "role"), "nose", "parts[2].tags"),
        ((*LEG, "tags", 0, "point_m"), [0, 0], "parts[2].tags[0].point_m"),
        ((*LEG, "tags", 0, "dipole"), [0, 0, 0], "parts[2].tags"),
        ((*LEG, "tags", 8), DELETED, "parts[2]"),  # a layout still names it
        ((*LEG, "layouts", 1, "epcs"), [], "parts[2].layouts[1]"),
        ((*LEG, "layouts", 1, "counterparts"), {"hand_left": "ff" * 12}, "parts[2].layouts[1]"),
        ((*LEG, "stable_poses"), [{"probability": 2, "T_support_part": []}], "parts[2].stable_poses[0]"),
        (("assemblies", 0, "parts"), ["table_leg_1", 2], "assemblies[0].parts[1]"),
        (("assemblies", 0, "parts"), [], "assemblies[0]"),
    ],
)
def test_a_defect_is_named_by_file_and_key(way, value, key):
    text = with_change(a_document(), way, value)
    with pytest.raises(InputError) as caught:
        parse_collection(text, "my_parts.json")
    assert caught.value.numbers["file"] == "my_parts.json"
    assert caught.value.numbers["key"] == key
    assert "my_parts.json" in caught.value.message


@pytest.mark.parametrize("text", ["", "{", "[]", "null", '{"schema": NaN}', '{"schema": 1, "schema": 1}', "[" * 10**5])
def test_a_file_that_holds_no_json_object_is_refused(text):
    with pytest.raises(PartError, match=r"f\.json"):
        parse_collection(text, "f.json")


def test_one_epc_on_two_parts_is_refused_and_both_are_named():
    document = a_document()
    document["parts"][1]["tags"][0]["epc"] = document["parts"][0]["tags"][0]["epc"].upper()
    document["parts"][1]["layouts"] = []
    with pytest.raises(DuplicateEpc, match="table_leg_1 and on part table_leg_2"):
        parse_collection(json.dumps(document), "f.json")


def test_a_part_that_stands_twice_is_refused():
    document = a_document()
    document["parts"].append({**document["parts"][0], "tags": [], "layouts": []})
    with pytest.raises(PartError, match="table_leg_1 stands 2 times"):
        parse_collection(json.dumps(document), "f.json")


@pytest.mark.parametrize("content", [b"\xff\xfe\x00", None])
def test_a_file_that_cannot_be_read_is_named(tmp_path, content):
    path = tmp_path / "parts.json"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(PartError, match=r"parts\.json: cannot be read") as caught:
        read_parts(path)
    assert caught.value.numbers["file"] == "parts.json"


def test_a_file_appears_whole_or_not_at_all(tmp_path, monkeypatch):
    path = tmp_path / "parts.json"
    path.write_text("before")

    def fail(descriptor):
        raise OSError("disk full")

    monkeypatch.setattr("rfcompass.files.os.fsync", fail)
    with pytest.raises(PartError, match="cannot be written: disk full"):
        write_parts(path, lack_table())
    assert path.read_text() == "before"
    assert [entry.name for entry in tmp_path.iterdir()] == ["parts.json"]


def test_a_written_file_is_readable_like_any_other(tmp_path):
    (tmp_path / "other").write_text("")
    write_parts(tmp_path / "parts.json", lack_table())
    modes = {stat.S_IMODE((tmp_path / name).stat().st_mode) for name in ("other", "parts.json")}
    assert len(modes) == 1
    assert json.loads((tmp_path / "parts.json").read_text())["schema"] == SCHEMA
