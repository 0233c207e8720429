"""Files that a URDF names are found, or the error says where they were looked for."""

import pytest

from rfcompass.errors import RobotModelError
from rfcompass.robots.packages import resolve


@pytest.fixture
def workspace(tmp_path):
    """src/arm/{package.xml, urdf/arm.urdf}, src/folder_name/package.xml that calls itself "hand"."""
    (tmp_path / "src/arm/urdf").mkdir(parents=True)
    (tmp_path / "src/arm/urdf/arm.urdf").touch()
    (tmp_path / "src/arm/package.xml").write_text("<package><name>arm</name></package>")
    (tmp_path / "src/folder_name").mkdir()
    (tmp_path / "src/folder_name/package.xml").write_text("<package><name> hand </name></package>")
    return tmp_path / "src"


def test_the_package_that_holds_the_urdf_is_found(workspace):
    found = resolve("package://arm/meshes/a.stl", workspace / "arm/urdf/arm.urdf")
    assert found == workspace / "arm/meshes/a.stl"


def test_a_package_beside_it_is_found(workspace):
    (workspace / "gripper").mkdir()
    found = resolve("package://gripper/a.stl", workspace / "arm/urdf/arm.urdf")
    assert found == workspace / "gripper/a.stl"


def test_a_package_is_known_by_its_manifest(workspace):
    found = resolve("package://hand/a.stl", workspace / "arm/urdf/arm.urdf", [workspace / "folder_name"])
    assert found == workspace / "folder_name/a.stl"


def test_given_folders_are_searched_first(workspace, tmp_path):
    (tmp_path / "overlay/arm").mkdir(parents=True)
    found = resolve("package://arm/a.stl", workspace / "arm/urdf/arm.urdf", [tmp_path / "overlay"])
    assert found == tmp_path / "overlay/arm/a.stl"


def test_plain_and_file_addresses_are_paths(tmp_path):
    assert resolve("meshes/a.stl", tmp_path / "r.urdf") == tmp_path / "meshes/a.stl"
    assert resolve(f"file://{tmp_path}/a%20b.stl", tmp_path / "r.urdf") == tmp_path / "a b.stl"


@pytest.mark.parametrize("uri", ["package://nobody/a.stl", "package:///a.stl", "http://example.org/a.stl"])
def test_what_cannot_be_found_is_an_error_that_names_it(uri, tmp_path):
    with pytest.raises(RobotModelError) as caught:
        resolve(uri, tmp_path / "r.urdf")
    assert uri in str(caught.value)
    assert caught.value.numbers["uri"] == uri
