"""The part database keeps what it was given, whole or not at all, and says what is wrong with a file."""

import gc
import os
import sqlite3
import subprocess
import sys
from contextlib import suppress
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from part_strategies import parts, same, some_parts

from rfcompass.errors import DuplicateEpc, InputError, PartDatabaseError, PartError, UnknownPart
from rfcompass.recordings.parts import PartCollection, PartDatabase, sqlite_file
from rfcompass.recordings.parts.lack import leg_epc, table_leg
from rfcompass.types.parts import Assembly, TagSelection, no_tags


def a_bare_part(part_id="crate", **changes):
    return replace(table_leg(9), part_id=part_id, tags=no_tags(part_id), selections=(), **changes)


@pytest.fixture
def database(tmp_path):
    with PartDatabase(tmp_path / "parts.sqlite") as database:
        yield database


def test_a_new_database_holds_the_table_of_the_paper(database):
    assert [leg.part_id for leg in database.assembly("LACK")] == [f"table_leg_{i}" for i in (1, 2, 3, 4)]
    assert same(database.part("table_leg_3"), table_leg(3))


def test_a_database_is_made_once_and_found_again(tmp_path):
    path = tmp_path / "new" / "folder" / "parts.sqlite"
    with PartDatabase(path) as database:
        database.remove_assembly("LACK")
        database.remove("table_leg_1")
    with PartDatabase(path) as database:
        assert database.part_ids() == ("table_leg_2", "table_leg_3", "table_leg_4")


def test_a_database_in_memory_leaves_no_file(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with PartDatabase(":memory:") as database:
        database.add(a_bare_part())
        assert database.part("crate").tags.epcs == ()
    assert not list(tmp_path.iterdir())


def test_the_location_comes_from_the_environment_or_the_home_folder(tmp_path, monkeypatch):
    monkeypatch.setenv("RFCOMPASS_PARTS", str(tmp_path / "mine.sqlite"))
    assert PartDatabase().location == str(tmp_path / "mine.sqlite")
    monkeypatch.delenv("RFCOMPASS_PARTS")
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.delenv("XDG_DATA_HOME", raising=False)
    monkeypatch.setattr(sys, "platform", "darwin")
    assert "Library/Application Support" in PartDatabase().location
    monkeypatch.setattr(sys, "platform", "linux")
    assert PartDatabase().location == str(tmp_path / ".local/share/rfcompass/parts.sqlite")
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))
    assert PartDatabase().location == str(tmp_path / "data/rfcompass/parts.sqlite")


def test_a_database_that_nobody_holds_closes_without_a_warning(tmp_path):
    assert PartDatabase(tmp_path / "parts.sqlite").part("table_leg_1").part_id == "table_leg_1"
    gc.collect()  # an unclosed connection would warn here, and warnings are errors


@settings(max_examples=20)
@given(parts())
def test_a_part_comes_back_as_it_was_stored(part):
    with PartDatabase(":memory:") as database:
        database.add(part, replace=True)
        assert same(database.part(part.part_id), part)
        for epc in part.tags.epcs:
            assert database.part_of_epc(epc.upper()).part_id == part.part_id


@settings(max_examples=12)
@given(some_parts(2))
def test_a_database_that_is_exported_and_imported_is_the_same(tmp_path_factory, some):
    path = tmp_path_factory.mktemp("exchange") / "parts.json"
    with PartDatabase(":memory:") as first, PartDatabase(":memory:") as second:
        first.add_collection(PartCollection(some), replace=True)
        first.export_file(path)
        imported = second.import_file(path, replace=True)
        assert second.part_ids() == first.part_ids()
        assert second.assemblies() == first.assemblies() == imported.assemblies
        assert all(same(a, b) for a, b in zip(first.parts(), second.parts(), strict=True))


@pytest.mark.parametrize(("asked", "near"), [("table_leg_33", "table_leg_3"), ("TABLE_LEG_2", "table_leg_2")])
def test_an_unknown_part_is_answered_with_those_spelt_alike(database, asked, near):
    with pytest.raises(UnknownPart, match=f"did you mean .*{near}") as caught:
        database.part(asked)
    assert caught.value.numbers["name"] == asked
    assert caught.value.numbers["near"][0] == near


def test_what_is_not_there_cannot_be_asked_for_or_removed(database):
    for ask in (
        lambda: database.part("spaceship"),
        lambda: database.remove("spaceship"),
        lambda: database.assembly("BILLY"),
        lambda: database.remove_assembly("BILLY"),
        lambda: database.part_of_epc("ff" * 12),
    ):
        with pytest.raises(UnknownPart):
            ask()
    with pytest.raises(UnknownPart, match="did you mean LACK"):
        database.assembly("LACKS")
    with pytest.raises(InputError, match="96-bit"):
        database.part_of_epc("12")


def test_one_epc_is_on_one_part_only(database):
    twin = replace(table_leg(3), part_id="twin", tags=replace(table_leg(3).tags, body="twin"))
    with pytest.raises(DuplicateEpc) as caught:
        database.add(twin)
    assert caught.value.numbers == {"epc": leg_epc(3, 1), "parts": ["table_leg_3", "twin"]}
    assert "twin" not in database.part_ids()


def test_an_epc_is_free_again_when_its_part_is_gone(database):
    database.remove_assembly("LACK")
    database.remove("table_leg_3")
    with pytest.raises(UnknownPart):
        database.part_of_epc(leg_epc(3, 1))
    twin = replace(table_leg(3), part_id="twin", tags=replace(table_leg(3).tags, body="twin"))
    database.add(twin)
    assert database.part_of_epc(leg_epc(3, 1)).part_id == "twin"


def test_a_part_is_replaced_only_when_asked(database):
    heavier = replace(table_leg(3), mass_kg=0.7)
    with pytest.raises(PartError, match="part table_leg_3: already in"):
        database.add(heavier)
    assert database.part("table_leg_3").mass_kg < 0.7
    database.add(heavier, replace=True)
    assert database.part("table_leg_3").mass_kg == 0.7
    assert len(database.assembly("LACK")) == 4


def test_two_parts_can_exchange_their_tags_in_one_import(database):
    one, two = table_leg(1), table_leg(2)
    swapped = PartCollection(
        (
            replace(one, tags=replace(two.tags, body=one.part_id), selections=two.selections),
            replace(two, tags=replace(one.tags, body=two.part_id), selections=one.selections),
        )
    )
    database.add_collection(swapped, replace=True)
    assert database.part_of_epc(leg_epc(1, 5)).part_id == "table_leg_2"


def test_a_part_that_a_product_needs_stays(database):
    with pytest.raises(PartError, match="belongs to LACK"):
        database.remove("table_leg_1")
    assert "table_leg_1" in database.part_ids()


def test_a_product_keeps_the_order_of_its_parts(database):
    database.add_assembly(Assembly("half", ("table_leg_4", "table_leg_2")))
    assert [part.part_id for part in database.assembly("half")] == ["table_leg_4", "table_leg_2"]
    with pytest.raises(PartError, match="assembly half: already"):
        database.add_assembly(Assembly("half", ("table_leg_1",)))
    database.add_assembly(Assembly("half", ("table_leg_1",)), replace=True)
    assert database.assemblies() == (
        Assembly("LACK", tuple(f"table_leg_{i}" for i in (1, 2, 3, 4))),
        Assembly("half", ("table_leg_1",)),
    )


def test_a_product_of_unknown_parts_is_refused(database):
    with pytest.raises(UnknownPart, match="named by assembly chair"):
        database.add_assembly(Assembly("chair", ("table_leg_1", "table_leg_7")))
    assert [assembly.name for assembly in database.assemblies()] == ["LACK"]


def test_an_import_happens_as_a_whole_or_not_at_all(database):
    clash = replace(a_bare_part("clash"), tags=replace(table_leg(1).tags, body="clash"))
    with pytest.raises(DuplicateEpc):
        database.add_collection(PartCollection((a_bare_part("fine"), clash)))
    with pytest.raises(UnknownPart):
        database.add_collection(PartCollection((a_bare_part("fine"),), (Assembly("set", ("fine", "missing")),)))
    assert database.part_ids() == tuple(f"table_leg_{i}" for i in (1, 2, 3, 4))


def test_an_interruption_undoes_all_changes_of_a_transaction(database):
    def change_and_be_interrupted():
        with database.transaction():
            database.add(a_bare_part())
            assert database.part("crate").part_id == "crate"
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        change_and_be_interrupted()
    with pytest.raises(UnknownPart):
        database.part("crate")


def test_a_process_that_dies_in_a_transaction_leaves_nothing_behind(tmp_path):
    path = tmp_path / "parts.sqlite"
    run_script(
        """
        database = PartDatabase(path)
        with database.transaction():
            database.remove_assembly("LACK")
            database.remove("table_leg_1")
            os._exit(0)
        """,
        path,
    ).wait(60)
    with PartDatabase(path) as database:
        assert len(database.assembly("LACK")) == 4


def test_two_processes_make_and_fill_one_database(tmp_path):
    path = tmp_path / "parts.sqlite"
    script = """
        database = PartDatabase(path)
        for i in range(15):
            part_id = f"{sys.argv[2]}_{i}"
            database.add(replace(table_leg(9), part_id=part_id, tags=no_tags(part_id), selections=()))
        """
    writers = [run_script(script, path, name) for name in ("a", "b")]
    assert [writer.wait(60) for writer in writers] == [0, 0]
    with PartDatabase(path) as database:
        assert len(database.part_ids()) == 4 + 2 * 15


def run_script(body, *arguments):
    head = (
        "import os, sys; from dataclasses import replace; from rfcompass.recordings.parts import PartDatabase;"
        "from rfcompass.recordings.parts.lack import table_leg; from rfcompass.types.parts import no_tags;"
        "path = sys.argv[1]"
    )
    lines = [line.removeprefix(" " * 8) for line in body.strip("\n").splitlines()]
    return subprocess.Popen([sys.executable, "-c", "\n".join([head, *lines]), *map(str, arguments)])


def test_a_reader_sees_the_state_before_an_unfinished_change(tmp_path):
    with PartDatabase(tmp_path / "parts.sqlite") as writer, PartDatabase(tmp_path / "parts.sqlite") as reader:
        with writer.transaction():
            writer.add(a_bare_part())
            assert "crate" not in reader.part_ids()
        assert "crate" in reader.part_ids()


def test_a_writer_that_waits_too_long_says_who_is_in_the_way(tmp_path, monkeypatch):
    monkeypatch.setattr(sqlite_file, "BUSY_TIMEOUT_S", 0.05)
    with PartDatabase(tmp_path / "parts.sqlite") as one, PartDatabase(tmp_path / "parts.sqlite") as two:
        with one.transaction(), pytest.raises(PartDatabaseError, match="in use by another process"):
            two.add(a_bare_part())
        two.add(a_bare_part())


@pytest.fixture
def whole_file(tmp_path):
    path = tmp_path / "whole.sqlite"
    PartDatabase(path).close()
    return path.read_bytes()


@pytest.mark.parametrize("share", [0.001, 0.01, 0.1, 0.5, 0.9, 0.999])
def test_a_truncated_file_is_refused_and_left_alone(tmp_path, whole_file, share):
    path = tmp_path / "parts.sqlite"
    path.write_bytes(whole_file[: int(len(whole_file) * share)])
    before = path.read_bytes()
    with pytest.raises(PartDatabaseError) as caught:
        PartDatabase(path)
    assert caught.value.numbers["file"] == str(path)
    assert path.read_bytes() == before


@given(st.integers(0, 10**6), st.integers(1, 255))
def test_a_flipped_byte_never_gives_an_error_without_a_type(tmp_path_factory, place, change):
    path = tmp_path_factory.mktemp("flip") / "parts.sqlite"
    PartDatabase(path).close()
    content = bytearray(path.read_bytes())
    content[place % len(content)] ^= change
    path.write_bytes(content)
    with suppress(InputError), PartDatabase(path) as database:
        database.collection()


def test_a_file_that_is_no_database_is_refused(tmp_path):
    path = tmp_path / "parts.sqlite"
    path.write_text("these are not the parts you are looking for" * 100)
    with pytest.raises(PartDatabaseError, match="not a database"):
        PartDatabase(path)


def test_the_database_of_another_program_is_refused_and_left_alone(tmp_path):
    path = tmp_path / "contacts.sqlite"
    connection = sqlite3.connect(path)
    connection.execute("CREATE TABLE contacts (name TEXT)")
    connection.close()
    before = path.read_bytes()
    with pytest.raises(PartDatabaseError, match="not one of parts"):
        PartDatabase(path)
    assert path.read_bytes() == before


def test_a_database_of_a_later_version_is_refused(tmp_path):
    path = tmp_path / "parts.sqlite"
    PartDatabase(path).close()
    connection = sqlite3.connect(path)
    connection.execute("PRAGMA user_version = 2")
    connection.close()
    with pytest.raises(PartDatabaseError, match="version 2, this software knows version 1"):
        PartDatabase(path)


def test_a_record_that_was_edited_by_hand_is_named(tmp_path):
    path = tmp_path / "parts.sqlite"
    PartDatabase(path).close()
    connection = sqlite3.connect(path)
    with connection:
        connection.execute("UPDATE part SET record = '{}' WHERE id = 'table_leg_2'")
    connection.close()
    with PartDatabase(path) as database:
        assert database.part("table_leg_1").part_id == "table_leg_1"
        with pytest.raises(PartDatabaseError, match="table_leg_2, key id: is missing"):
            database.part("table_leg_2")


@pytest.mark.parametrize("make", [lambda path: path.mkdir(), lambda path: path.parent.joinpath("x").touch()])
def test_a_place_where_no_file_can_be_is_named(tmp_path, make):
    path = tmp_path / "parts.sqlite"
    make(path)
    place = path if path.exists() else tmp_path / "x" / "parts.sqlite"
    with pytest.raises(PartDatabaseError) as caught:
        PartDatabase(place)
    assert caught.value.numbers["file"] == str(place)


@pytest.mark.skipif(os.geteuid() == 0, reason="root writes read-only files")
def test_a_read_only_file_can_be_read_but_not_changed(tmp_path):
    path = tmp_path / "parts.sqlite"
    PartDatabase(path).close()
    path.chmod(0o444)
    with PartDatabase(path) as database:
        assert database.collection().parts
        with pytest.raises(PartDatabaseError, match="readonly"):
            database.add(a_bare_part())


def test_a_closed_database_says_so(database):
    database.close()
    database.close()
    with pytest.raises(PartDatabaseError, match="closed"):
        database.part_ids()


def test_a_tag_may_be_in_several_layouts_of_its_part(database):
    layouts = [selection for selection in database.part("table_leg_1").selections if leg_epc(1, 9) in selection.epcs]
    assert [selection.K for selection in layouts] == [2, 3, 4]
    assert all(isinstance(selection, TagSelection) for selection in layouts)
