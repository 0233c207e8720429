"""From a URDF to the arrays of a `JointChain`."""

from collections.abc import Sequence
from xml.etree.ElementTree import Element

import numpy as np

from rfcompass.robots.joint_chain import JointChain
from rfcompass.robots.kinematics import Kinematics
from rfcompass.robots.urdf_xml import axis_of


def build_chain(kinematics: Kinematics, urdf: Element, tag_links: Sequence[str]) -> JointChain:
    """Collect the joints that move any of the tags.

    Args:
        kinematics: Places of joints and tags at rest, and the order of the joint values.
        urdf: The same robot; its axes, kinds and mimic rules.
        tag_links: Links of the tags (N).

    Raises:
        RobotModelError: If a tag's link is missing.
    """
    model = kinematics.model
    riding = [kinematics.placement(kinematics.frame_id(link)) for link in tag_links]
    joint_ids = sorted({int(i) for joint_id, _ in riding for i in model.supports[joint_id]} - {0})
    row = {0: -1} | {joint_id: j for j, joint_id in enumerate(joint_ids)}
    places = [kinematics.joint_placement(joint_id) for joint_id in joint_ids]
    elements = {joint.get("name"): joint for joint in urdf.findall("joint")}
    moving = [elements[model.names[joint_id]] for joint_id in joint_ids]
    rows = np.array(joint_ids, dtype=np.int64) - 1
    gain = kinematics.joint_map.gain[rows]
    J, N = len(joint_ids), len(riding)
    return JointChain(
        parent=np.array([row[parent] for parent, _ in places], dtype=np.int64),
        R=np.array([T.rotation for _, T in places]).reshape(J, 3, 3),
        p=np.array([T.translation for _, T in places]).reshape(J, 3),
        axis=np.array([axis_of(joint) for joint in moving]).reshape(J, 3),
        slides=np.array([joint.get("type") == "prismatic" for joint in moving], dtype=bool),
        value=np.abs(gain).argmax(axis=1) if gain.size else np.zeros(J, dtype=np.int64),
        scale=gain.sum(axis=1),
        offset=kinematics.joint_map.offset[rows],
        tag_joint=np.array([row[joint_id] for joint_id, _ in riding], dtype=np.int64),
        tag_p=np.array([T.translation for _, T in riding]).reshape(N, 3),
    )
