"""What the page "Your own robot" says works as it stands: its files and its code are taken from the page."""

import json
import re
import shutil
from pathlib import Path

import numpy as np
import pytest

from rfcompass.robots.layouts import data_folder

PAGE = (Path(__file__).parents[2] / "docs" / "own_robot.md").read_text(encoding="utf-8")


def blocks(language):
    return re.findall(rf"```{language}\n(.*?)```", PAGE, re.DOTALL)


@pytest.mark.slow
def test_the_page_leads_from_a_urdf_to_a_page_of_a_grasp(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    shutil.copy(data_folder() / "ur5e_2f85.urdf", tmp_path)
    robot, tags = map(json.loads, blocks("json"))
    Path("my_ur5e.json").write_text(json.dumps(robot))
    Path(robot["tag_layout"]).write_text(json.dumps(tags))
    *steps, _picture = blocks("python")
    names = {}
    exec("\n".join(steps), names)
    assert names["robot"].layout.epcs == ("300800000000000000000000",)
    tool = names["robot"].tool_pose(names["answer"].configuration)
    assert tool.translation == pytest.approx(names["task"].point_m, abs=1e-5)
    assert np.mean(names["reach"].reached) == pytest.approx(0.92, abs=0.02)
    assert "my_ur5e" in Path("my_ur5e.html").read_text(encoding="utf-8")
