"""`rfcompass parts` and `rfcompass robots`."""

import numpy as np
import pytest
import trimesh

from rfcompass.robots import check_urdf
from rfcompass.robots.layouts import data_folder

YOUBOT = data_folder() / "youbot.urdf"


@pytest.fixture
def database(tmp_path):
    return tmp_path / "parts.sqlite"


def test_the_four_legs_are_there_from_the_start(run, database):
    answer = run("parts", "list", "--database", database, "--json").json
    assert answer["parts"] == [f"table_leg_{i}" for i in (1, 2, 3, 4)]
    assert answer["assemblies"]["LACK"] == answer["parts"]
    assert "table_leg_1" in run("parts", "list", "--database", database).out


def test_a_part_shows_its_size_and_its_tags(run, database):
    leg = run("parts", "show", "table_leg_3", "--database", database, "--json").json
    assert np.allclose(leg["size_m"], [0.40, 0.05, 0.05])
    assert {layout["K"] for layout in leg["layouts"]} == {1, 2, 3, 4}
    assert "K=4 inset" in run("parts", "show", "table_leg_3", "--database", database).out


def test_a_mesh_becomes_a_part_that_can_be_removed_again(run, database, tmp_path):
    mesh = tmp_path / "leg.stl"
    trimesh.creation.box((400, 50, 50)).export(mesh)
    tag = "30080000000000000000000a,0.2,0,0"
    ran = run("parts", "add", "my_leg", "--mesh", mesh, "--unit", "mm", "--density", 500, "--tag", tag,
              "--database", database, "--json")  # fmt: skip
    assert ran.code == 0, ran.err
    assert np.allclose(ran.json["size_m"], [0.4, 0.05, 0.05])
    assert ran.json["mass_kg"] == pytest.approx(0.5)
    assert run("parts", "show", "my_leg", "--database", database).code == 0
    assert run("parts", "remove", "my_leg", "--database", database).code == 0
    assert run("parts", "show", "my_leg", "--database", database).code == 2


def test_a_box_becomes_a_part(run, database):
    ran = run("parts", "add", "brick", "--box", 0.1, 0.2, 0.05, "--database", database, "--json")
    assert ran.code == 0, ran.err
    assert ran.json["grasp_width_m"] == pytest.approx(0.1)


def test_parts_travel_as_json(run, database, tmp_path):
    file, other = tmp_path / "parts.json", tmp_path / "other.sqlite"
    run("parts", "add", "brick", "--box", 0.1, 0.2, 0.05, "--database", database)
    assert run("parts", "export", file, "--database", database).code == 0
    assert run("parts", "import", file, "--database", other).code == 2  # the legs are there already
    assert run("parts", "import", file, "--overwrite", "--database", other).code == 0
    listed = [run("parts", "list", "--database", one, "--json").json for one in (database, other)]
    assert listed[0] == listed[1]


@pytest.mark.parametrize(
    "arguments",
    [
        ("show", "table_leg_9"),
        ("remove", "table_leg_9"),
        ("add", "x"),
        ("add", "x", "--box", 0.1, 0.2, -0.05),
        ("add", "x", "--box", 0.1, 0.2, 0.05, "--tag", "nonsense"),
        ("add", "x", "--box", 0.1, 0.2, 0.05, "--tag", "zz,0,0,0"),
        ("add", "x", "--mesh", "nowhere.stl"),
        ("import", "nowhere.json"),
    ],
)
def test_what_cannot_be_is_bad_input_and_changes_nothing(run, database, arguments):
    before = run("parts", "list", "--database", database, "--json").json
    assert run("parts", *arguments, "--database", database, "--json").code == 2
    assert run("parts", "list", "--database", database, "--json").json == before


def test_robots_are_known_by_name(run):
    answer = run("robots", "list", "--json").json
    assert "youbot" in answer["robots"]
    assert {"youbot_x4", "youbot_l0", "youbot_skew6"} <= set(answer["layouts"])


def test_our_youbot_has_no_error(run):
    answer = run("robots", "check", YOUBOT, "--json").json
    assert answer["ok"]
    assert "arm_joint_1" in answer["moving"]


def test_a_robot_is_checked_by_its_name_with_the_links_that_its_description_needs(run, tmp_path, monkeypatch):
    answer = run("robots", "check", "ur5e_2f85", "--json").json
    assert answer["ok"]
    assert answer["file"].endswith("ur5e_2f85.urdf")
    assert run("robots", "check", "nobody", "--json").code == 2
    asked = []
    monkeypatch.setattr("rfcompass.robots.check_urdf", lambda *args: asked.append(args) or check_urdf(*args))
    run("robots", "check", "ur5e_2f85", "--frame", "tool0")
    assert {"base_link", "gripper_tool_link", "gripper_palm_link", "tool0"} == set(asked[0][2])


def test_every_defect_of_a_urdf_is_named(run, tmp_path):
    broken = tmp_path / "broken.urdf"
    text = YOUBOT.read_text().replace('<parent link="arm_link_4"/>', '<parent link="nowhere"/>')
    broken.write_text(text.replace("</robot>", '<link name="m"><visual><geometry><mesh filename="package://x/y.stl"/>'
                                   "</geometry></visual></link></robot>"))  # fmt: skip
    ran = run("robots", "check", broken, "--frame", "no_such_tool", "--json")
    assert ran.code == 2
    assert {"missing_frame", "unknown_package"} <= {defect["kind"] for defect in ran.json["defects"]}
    assert any("nowhere" in defect["message"] for defect in ran.json["defects"])


def test_a_urdf_with_an_external_entity_is_refused(run, tmp_path):
    (tmp_path / "secret").write_text("secret")
    hostile = tmp_path / "hostile.urdf"
    entity = f'<!DOCTYPE robot [<!ENTITY x SYSTEM "file://{tmp_path}/secret">]>'
    hostile.write_text(f'{entity}<robot name="&x;"><link name="a"/></robot>')
    ran = run("robots", "check", hostile, "--json")
    assert ran.code == 2
    assert ran.json["defects"][0]["kind"] == "document_type"
    assert "secret" not in ran.json["name"]


def test_a_urdf_gets_its_tags(run, tmp_path):
    tagged = tmp_path / "tagged.urdf"
    ran = run("robots", "tag", YOUBOT, "youbot_skew6", "--out", tagged, "--json")
    assert (ran.code, ran.json["tags"]) == (0, 6)
    assert run("robots", "check", tagged, "--frame", "tag_6").code == 0
    assert run("robots", "tag", YOUBOT, "no_such_layout", "--out", tmp_path / "x.urdf").code == 2
    assert not (tmp_path / "x.urdf").exists()
