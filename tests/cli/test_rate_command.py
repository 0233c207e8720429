"""`rfcompass rate` tells the best grasps of a file, and writes all that it was asked for or nothing."""

import io

import numpy as np
import pytest
from box_scenes import Block, looking_down, see

from planners.best_grasps import best_grasps
from planners.grasp_quality import AntipodalQuality
from rfcompass.types import DepthView

SHAPE, HEIGHT_M, FOCAL = (90, 160), 0.5, 178.0
K = np.array([[FOCAL, 0, 79.5], [0, FOCAL, 44.5], [0, 0, 1]])
VIEW = see([Block((0.05, 0.0, 0.025), (0.06, 0.04, 0.05), 0.3)], looking_down(0.0, 0.0, HEIGHT_M), K, SHAPE)[0]
ARRAYS = {"depth_m": VIEW.depth_m, "intrinsics": VIEW.intrinsics, "T_world_camera": VIEW.T_world_camera}


@pytest.fixture
def file(tmp_path):
    np.savez(tmp_path / "view.npz", **ARRAYS)
    return tmp_path / "view.npz"


def test_it_tells_the_best_grasps_of_the_image(run, file):
    told = run("rate", file, "--best", 3, "--json")
    assert told.code == 0, told.err
    grasps = best_grasps(VIEW, AntipodalQuality().quality(VIEW), 3)
    assert [(one["row"], one["column"], one["quality"]) for one in told.json["grasps"]] == [
        (grasp.row, grasp.column, grasp.quality) for grasp in grasps
    ]
    for one, grasp in zip(told.json["grasps"], grasps, strict=True):
        assert np.array_equal(one["T_world_hand"], grasp.T_world_hand)
        assert one["aperture_m"] == grasp.aperture_m
    assert f"{grasps[0].quality:.2f}" in run("rate", file).out


def test_millimetres_with_holes_of_zero_are_read_as_such(run, tmp_path):
    depth_mm = np.round(1000 * VIEW.depth_m).astype(np.uint16)
    depth_mm[:3] = 0
    np.savez(tmp_path / "mm.npz", **{**ARRAYS, "depth_mm": depth_mm})
    both = run("rate", tmp_path / "mm.npz", "--json")
    assert (both.code, both.json["failure"]["kind"]) == (2, "InputError")  # which of the two is meant?
    arrays = {name: array for name, array in ARRAYS.items() if name != "depth_m"}
    np.savez(tmp_path / "mm.npz", depth_mm=depth_mm, **arrays)
    depth_m = np.where(depth_mm > 0, depth_mm / 1000, np.nan)
    (best,) = best_grasps(view := DepthView(depth_m, K, VIEW.T_world_camera), AntipodalQuality().quality(view), 1)
    assert run("rate", tmp_path / "mm.npz", "--json").json["grasps"][0]["quality"] == best.quality


def test_the_table_may_be_elsewhere(run, tmp_path):
    T = VIEW.T_world_camera.copy()
    T[2, 3] += 0.7
    np.savez(tmp_path / "high.npz", **{**ARRAYS, "T_world_camera": T})
    told = run("rate", tmp_path / "high.npz", "--table", 0.7, "--json").json["grasps"][0]
    low = best_grasps(VIEW, AntipodalQuality().quality(VIEW), 1)[0]
    assert told["quality"] == pytest.approx(low.quality, abs=1e-6)
    assert told["T_world_hand"][2][3] == pytest.approx(low.T_world_hand[2, 3] + 0.7)


@pytest.mark.parametrize("colour", [False, True])
def test_maps_and_picture_are_written_once(run, tmp_path, colour):
    more = {"colour": np.full((*SHAPE, 3), 90, np.uint8)} if colour else {}
    np.savez(tmp_path / "view.npz", **ARRAYS, **more)
    maps, picture = tmp_path / "out" / "maps.npz", tmp_path / "out" / "grasps.png"
    ran = run("rate", tmp_path / "view.npz", "--maps", maps, "--picture", picture)
    assert ran.code == 0, ran.err
    rated = AntipodalQuality().quality(VIEW)
    with np.load(maps) as stored:
        assert set(stored) == {"quality", "angle_rad", "width_m", "depth_m"}
        assert all(np.array_equal(stored[name], getattr(rated, name)) for name in stored)
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert sorted(path.name for path in picture.parent.iterdir()) == ["grasps.png", "maps.npz"]
    before = picture.read_bytes()
    assert run("rate", tmp_path / "view.npz", "--picture", picture).code == 2
    assert picture.read_bytes() == before
    assert run("rate", tmp_path / "view.npz", "--picture", picture, "--overwrite").code == 0


def test_a_table_that_is_higher_than_was_said_is_pointed_out(run, file, tmp_path):
    assert "--table" not in run("rate", file).err
    assert "10 mm over the table" in run("rate", file, "--table", -0.010).err


def test_an_empty_table_is_no_answer(run, tmp_path):
    flat = {**ARRAYS, "depth_m": np.full(SHAPE, HEIGHT_M)}
    np.savez(tmp_path / "flat.npz", **flat)
    ran = run("rate", tmp_path / "flat.npz", "--json")
    assert (ran.code, ran.json["failure"]["kind"]) == (1, "NothingToGrasp")


@pytest.mark.parametrize(
    "arrays",
    [
        {},
        {name: ARRAYS[name] for name in ("depth_m", "intrinsics")},
        {**ARRAYS, "depth_m": np.array([["a", "b"]])},
        {**ARRAYS, "depth_m": np.ones(5)},
        {**ARRAYS, "intrinsics": np.eye(2)},
        {**ARRAYS, "T_world_camera": np.zeros((4, 4))},
        {**ARRAYS, "depth_m": 1000 * VIEW.depth_m},
        {**ARRAYS, "depth_m": np.array([None])},
        {**ARRAYS, "depth_m": VIEW.depth_m + 0j},
        {**ARRAYS, "T_world_camera": looking_down(0.0, 0.0, 1000 * HEIGHT_M)},
        {**ARRAYS, "colour": np.full((*SHAPE, 3), 0.3)},
        {**ARRAYS, "colour": np.zeros(SHAPE, int)},
    ],
    ids=[
        "nothing",
        "no pose",
        "words",
        "a row",
        "small matrix",
        "no pose at all",
        "millimetres",
        "objects",
        "complex",
        "camera in millimetres",
        "colours from 0 to 1",
        "grey",
    ],
)
def test_what_is_no_image_is_refused_and_nothing_is_written(run, tmp_path, arrays):
    np.savez(tmp_path / "view.npz", **arrays)
    ran = run("rate", tmp_path / "view.npz", "--maps", tmp_path / "out" / "maps.npz", "--json")
    assert ran.code == 2, ran.out
    assert ran.json["failure"]["kind"] in ("InputError", "ShapeError")
    assert not (tmp_path / "out").exists()


def damaged(how):
    """A file of arrays with an error in it: data that cannot be unpacked, or that claims to be locked."""
    stored = io.BytesIO()
    np.savez_compressed(stored, **ARRAYS)
    content = bytearray(stored.getvalue())
    if how == "locked":
        content[6] |= 1  # in the first entry's own header and, below, in the list of entries at the end
        at = content.index(b"PK\x01\x02")
        content[at + 8] |= 1
    else:
        content[60:200] = bytes(140)
    return bytes(content)


@pytest.mark.parametrize(
    "content",
    [None, b"", b"no archive", b"PK\x03\x04 half of one", damaged("locked"), damaged("torn")],
    ids=["none", "empty", "text", "half", "locked", "torn"],
)
def test_a_file_that_is_none_is_refused(run, tmp_path, content):
    if content is not None:
        (tmp_path / "view.npz").write_bytes(content)
    ran = run("rate", tmp_path / "view.npz", "--json")
    assert (ran.code, ran.json["failure"]["kind"]) == (2, "InputError")


def test_a_single_array_is_refused(run, tmp_path):
    np.save(tmp_path / "depth.npy", VIEW.depth_m)
    ran = run("rate", tmp_path / "depth.npy", "--json")
    assert (ran.code, ran.json["failure"]["found"]) == (2, ["one array"])


@pytest.mark.parametrize("name", ["maps.txt", "maps", "file/maps.npz", "view.npz", "loop/maps.npz", 300 * "m" + ".npz"])
def test_a_place_that_cannot_be_is_refused_before_anything_is_computed(run, file, tmp_path, name, monkeypatch):
    def too_late(*_):
        raise AssertionError("computed already")

    monkeypatch.setattr(AntipodalQuality, "quality", too_late)
    (tmp_path / "file").write_text("")
    (tmp_path / "loop").symlink_to(tmp_path / "loop")
    before = file.read_bytes()
    ran = run("rate", file, "--maps", tmp_path / name, "--overwrite", "--json")
    assert file.read_bytes() == before
    assert ran.code == 2
    assert ran.json["failure"]["kind"] in ("InputError", "TraceError")
