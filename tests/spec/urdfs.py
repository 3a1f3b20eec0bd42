"""URDFs of the tests: a small arm with all that a reader meets, in pieces that a test can replace."""

from __future__ import annotations

ARM = """\
<?xml version="1.0"?>
<!-- a small arm -->
<robot name="Small Arm">
  <link name="base"/>
  <link name="upper-arm">
    <inertial>
      <origin xyz="0.1 0 0.02" rpy="0.3 0 0"/>
      <mass value="2.5"/>
      <inertia ixx="0.02" ixy="0.001" ixz="0" iyy="0.03" iyz="-0.002" izz="0.04"/>
    </inertial>
  </link>
  <link name="camera">
    <inertial>
      <mass value="0.25"/> <!-- weighed -->
      <inertia ixx="1e-4" ixy="0" ixz="0" iyy="1e-4" iyz="0" izz="1e-4"/>
    </inertial>
  </link>
  <link name="slider">
    <inertial>
      <origin xyz="0 0.05 0"/>
      <mass value="1.5"/>
      <inertia ixx="0.01" ixy="0" ixz="0" iyy="0.012" iyz="0" izz="0.014"/>
    </inertial>
  </link>
  <joint name="shoulder joint" type="revolute">
    <origin xyz="0 0 0.4" rpy="0 0 1.5707963267948966"/>
    <parent link="base"/>
    <child link="upper-arm"/>
    <axis xyz="0 1 0"/>
    <limit lower="-1.5" upper="1.5" effort="40" velocity="2"/>
    <dynamics damping="0.7" friction="0.2"/>
  </joint>
  <joint name="camera_mount" type="fixed">
    <origin xyz="0.2 0 0.1" rpy="0 0.5 0"/>
    <parent link="upper-arm"/>
    <child link="camera"/>
  </joint>
  <joint name="slide" type="prismatic">
    <origin xyz="0.3 0.1 0" rpy="0.2 -0.4 0.6"/>
    <parent link="upper-arm"/>
    <child link="slider"/>
    <axis xyz="1 0 1"/>
    <limit lower="0" upper="0.2" effort="10" velocity="1"/>
  </joint>
  <transmission name="t"><actuator name="m"><mechanicalReduction>50</mechanicalReduction></actuator></transmission>
  <gazebo reference="slider"><material>Gazebo/Grey</material></gazebo>
  <mujoco><compiler angle="radian"/></mujoco>
</robot>
"""

# A moving torso with two arms, one of them with a gripper of two fingers.
TREE_LINKS = ("base", "torso", "left", "right", "hand", "finger_1", "finger_2")
TREE_JOINTS = (
    ("lift", "prismatic", "base", "torso", ""),
    ("left_shoulder", "revolute", "torso", "left", ""),
    ("right_shoulder", "revolute", "torso", "right", ""),
    ("wrist", "fixed", "left", "hand", ""),
    ("grip_1", "prismatic", "hand", "finger_1", ""),
    ("grip_2", "prismatic", "hand", "finger_2", '<mimic joint="grip_1"/>'),
)


def tree(joints: tuple[tuple[str, str, str, str, str], ...] = TREE_JOINTS) -> str:
    body = '<inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>'
    links = "".join(f'<link name="{name}">{body}</link>\n' for name in TREE_LINKS)
    lines = "".join(
        f'<joint name="{name}" type="{kind}"><origin xyz="0.1 0.2 0.3"/><parent link="{parent}"/>'
        f'<child link="{child}"/><axis xyz="0 0 1"/>{more}</joint>\n'
        for name, kind, parent, child, more in joints
    )
    return f'<robot name="tree">\n{links}{lines}</robot>\n'
