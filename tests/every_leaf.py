"""Two case files that hold every key there is, each number unlike all others.

Each number is unlike its default, too. What they name beside them is written by
`write_models`.
"""

import trimesh


MAIN = """
name: every_leaf
description: each of its numbers is unlike all others
pair: {A: carrier, B: craft, direction: [0.7891, 0.5123, 0.338925]}
bodies:
  carrier:
    mass_kg: 711.5
    cg_mm: [-801.5, 51.5, -31.5]
    inertia_kg_m2: {xx: 301.5, yy: 421.5, zz: 381.5, xy: 12.5, xz: -15.5, yz: 8.5}
    geometry:
      plate:
        box: {size_mm: [211, 1213, 1411]}
        position_mm: [-1901, 61, -71]
        attitude_deg: [1.25, -2.25, 3.25]
        role: a plate
      ball: {sphere: {radius_mm: 151}, position_mm: [-1301, 901, 81]}
      rod:
        capsule: {radius_mm: 53, length_mm: 257}
        position_mm: [-1303, -903, 83]
        attitude_deg: [4.25, 5.25, -6.25]
        role: antenna
  craft:
    mass_kg: 1213.5
    cg_mm: [1101.5, -20.75, 41.5]
    inertia_kg_m2: {xx: 501.5, yy: 821.5, zz: 781.5, xy: -22.5, xz: 25.5, yz: 18.5}
    mated: {position_mm: [11, -7, 5], attitude_deg: [7.25, -8.25, 9.25]}
    geometry:
      skirt:
        cylinder: {radius_mm: 307, length_mm: 311, thickness_mm: 13}
        position_mm: [409, 17, -19]
        attitude_deg: [-1.75, 2.75, -3.75]
      nose:
        cone: {radius_aft_mm: 317, radius_fore_mm: 109, length_mm: 503, thickness_mm: 3}
        position_mm: [1709, 27, -29]
        role: nose
      block:
        mesh: {file: block.stl, scale: 0.0023}
        position_mm: [2309, 37, -39]
        attitude_deg: [-4.75, 5.75, 6.875]
  tail:
    mass_kg: 93.5
    cg_mm: [-13.5, 3.5, 2.5]
    inertia_kg_m2: {xx: 9.625, yy: 10.5, zz: 11.5}
    mated: {position_mm: [-2011, 207, -105]}
attachments:
  hinge:
    A: carrier
    B: craft
    position_mm: [23, 431, 211.5]
    joint:
      type: cylindrical
      stiffness_N_m: [200001, 210001, 220001]
      damping_N_s_m: [2001, 2101, 2201]
      angular_stiffness_N_m_rad: [30001, 31001, 32001]
      angular_damping_N_m_s_rad: [401, 411, 421]
      axes: {x: [0, 0.28, 0.96], y: [0.8, 0.576, -0.168]}
    release_time_s: 0.0625
    release_angle_deg: 37.5
    release_travel_mm: 418.5
  bolt:
    A: carrier
    B: craft
    position_mm: [30, -433, 213]
    joint:
      type: spherical
      stiffness_N_m: 230001
      damping_N_s_m: 2301
      angular_stiffness_N_m_rad: 33001
      angular_damping_N_m_s_rad: 441
    spring:
      name: timed
      axis: [0.1234, 0.2345, 0.964252]
      law: time
      force_max_N: 1201.5
      stroke_mm: 97
      design_mass_kg: 107.5
      tilt_y_deg: 1.625
      tilt_z_deg: -2.625
      lost_stroke: 0.0725
    release_time_s: 0.03125
  latch:
    A: carrier
    B: craft
    position_mm: [31, 7.5, -439]
    joint: &slack
      stiffness_N_m: 0
      damping_N_s_m: 0
      angular_stiffness_N_m_rad: 0
      angular_damping_N_m_s_rad: 0
    spring:
      name: wound
      axis: [-0.3456, 0.4567, 0.819747]
      law: displacement
      force_max_N: 1303.5
      stroke_mm: 89
      damping_N_s_m: 43
      tilt_y_deg: -3.625
      tilt_z_deg: 4.625
      lost_stroke: 0.0825
  strap:
    A: tail
    B: carrier
    position_mm: [47, -9.5, 103]
    joint: *slack
    spring:
      name: measured
      axis: [0.5678, -0.6789, 0.465508]
      law: table
      displacements_mm: [0, 20.5, 59]
      forces_N: [307.5, 411.5, 101.75]
      damping_N_s_m: 19.5
      tilt_y_deg: 5.625
      tilt_z_deg: -6.625
      lost_stroke: 0.0925
  plug:
    A: carrier
    B: craft
    position_mm: [41, 81.5, 305]
    joint: *slack
    spring:
      name: pin
      axis: [0.6788, -0.1233, 0.723898]
      law: connector
      force_max_N: 61.75
      travel_mm: 6.5
      tilt_y_deg: 0.725
      tilt_z_deg: -0.825
  socket:
    A: carrier
    B: craft
    position_mm: [46.5, 83.5, 315]
    joint: *slack
    spring:
      name: seal
      axis: [0.7895, -0.2346, 0.567144]
      law: connector_table
      displacements_mm: [0, 3.4375, 8.875]
      forces_N: [71.25, 31.25, 11.25]
      tilt_y_deg: 0.925
      tilt_z_deg: -1.025
  runner:
    A: carrier
    B: craft
    position_mm: [48.5, 85.5, 325]
    joint: *slack
    spring:
      name: rub
      axis: [0.5555, -0.4444, 0.702769]
      law: guide
      force_max_N: 17.375
      travel_mm: 19.25
      tilt_y_deg: 1.375
      tilt_z_deg: -1.4375
loads:
  jet:
    body: craft
    position_mm: [103.5, 207.5, -309.5]
    direction: [0.48, -0.6, 0.64]
    times_s: [0.015, 0.215]
    thrusts_N: [503.5, 907.5]
    start_s: 0.045
    after: latch
  gust:
    body: carrier
    position_mm: [-111.5, 222.5, 333.5]
    axes: world
    times_s: [0.025, 0.325, 0.425]
    forces_N: [[11.2, -12.2, 13.2], [14.2, 15.2, -16.2], [-17.2, 18.2, 19.2]]
    torques_N_m: [[1.2, 2.2, -3.2], [-4.2, 5.2, 6.2], [7.2, -8.2, 9.2]]
    start_s: 0.055
orbit:
  altitude_km: 613
  inclination_deg: 51.6875
  ascending_node_deg: 217.0625
  argument_of_latitude_deg: 133.8125
  frame: GCRF
  epoch: '2027-02-03T04:05:06.25'
  time_system: TAI
before_separation:
  attitude_deg: [21.5, -30.5, 40.5]
  rate_deg_s: [3.125, -4.125, 5.125]
dispersions:
  craft.mass_kg: 33.25
  craft.cg_x_mm: 6.75
  craft.inertia_xy_kg_m2: 1.125
  timed.tilt_z_deg: 0.375
  hinge.release_angle_deg: 0.875
  before_separation.rate_y_deg_s: 0.625
  bolt.release_time_s: 0.0085
  jet.factor: 0.095
  craft.cg_y_mm: {lower: -123.0625, upper: 256.4375}
  craft.cg_z_mm: {minus: 2.875, plus: 7.625}
  carrier.mass_kg: {tolerance: 4.3125, distribution: normal, sigmas: 2.375}
  carrier.cg_x_mm: {uniform: {lower: -811.375, upper: -790.875}, within: 1.96875}
  carrier.cg_y_mm: {triangular: {minus: 1.21875, plus: 2.46875}}
  carrier.cg_z_mm: {normal: {sigma: 0.34375}}
  tail.mass_kg: {truncated_normal: {sigma: 1.03125, tolerance: 2.09375}}
  wound.force_max_N: {lognormal: {sigma: 6.53125}}
  timed.force_max_N:
    table: {values: [1190.25, 1205.25, 1215.75], weights: [1.15625, 2.28125, 0.84375]}
  measured.force_max_N:
    discrete: {values: [405.125, 411.625], probabilities: [0.28125, 0.71875]}
ellipsoids:
  - parameters: [craft.mass_kg, craft.cg_x_mm, jet.factor]
    correlation: [[1, 0.31, -0.21], [0.31, 1, 0.11], [-0.21, 0.11, 1]]
correlations: [{of: [wound.force_max_N, timed.force_max_N], rank: 0.4375}]
requirements:
  - {quantity: clearance_mm, at_least: 2.125, until_separation_mm: 87.5}
  - {quantity: rate_after_separation_deg_s, at_most: [64, 65, 66]}
  - {quantity: deviation_at_separation_deg, at_least: [0.165, 0.175, 0.185]}
  - quantity: rate_deg_s
    when: {at_s: 0.4125}
    at_most: [67, null, 68]
    pair: craft
    id: UM-1
    source: guide
  - quantity: rate_deg_s
    when: {from_s: 0.1725, to_s: 0.5525}
    at_most: [null, 69, null]
  - quantity: joint_force_N
    of: bolt
    at_most: 90001
    share: 0.9825
    confidence: 0.8125
    sides: two
  - quantity: clearance_mm
    pair: craft
    to: carrier
    at_least: 3.375
    until_separation_mm: 97.5
  - quantity: no_contact
    parts: [[ball, skirt], [rod, nose]]
    until_separation_mm: 106.25
objectives: paper
clearance:
  pairs: [[plate, skirt], [ball, nose]]
  touching: [[rod, block], [plate, nose]]
recontact:
  stiffness_N_m: 70001
  face_stiffness_N_m3: 810001
  dissipation_s_m: 0.7125
  friction: 0.2125
failure_cases:
  worn: {craft.mass_kg: max, carrier.mass_kg: 722.5}
failures: {worn: 0.015625}
run:
  duration_s: 0.59
  integrator: bogacki_shampine3
  accuracy: 3.0e-4
  max_step_s: 0.0175
  time_limit_s: 877.5
published:
  - label: theirs
    objectives: [L2, PM]
    values: {craft.mass_kg: M, craft.cg_x_mm: m, carrier.mass_kg: 733.5}
    printed:
      rate_deg_s: [0.515, 0.525, 0.535]
      deviation_within_limits_until_s: 0.305
      longitudinal_speed_m_s: 0.405
      iterations: 18
"""

SOLIDS = """
name: solids
pairs: [{A: base, B: brick}]
bodies:
  base: {model: {file: two.urdf, frame: arm}}
  brick:
    solid:
      box: {size_mm: [1100, 1300, 1700]}
      mass_kg: 210
      position_mm: [901, 31, -41]
      attitude_deg: [0, 0, 90]
  drum:
    solid:
      cylinder: {radius_mm: 450, length_mm: 2100}
      density_kg_m3: 55
      position_mm: [3, 5, 7]
  orb: {solid: {sphere: {radius_mm: 350}, mass_kg: 65, position_mm: [13, 17, 19]}}
  egg:
    solid:
      ellipsoid: {semi_axes_mm: [610, 420, 530]}
      mass_kg: 75
      position_mm: [23, 29, 37]
      attitude_deg: [90, 0, 0]
  pill:
    solid:
      capsule: {radius_mm: 240, length_mm: 920}
      mass_kg: 85
      position_mm: [43, 47, 53]
  slab:
    spin_deg_s: -7.25
    solid:
      mesh: {file: block.stl, scale: 0.0023}
      density_kg_m3: 131
      position_mm: [59, 61, 67]
      attitude_deg: [0, 90, 0]
attachments:
  one:
    A: base
    B: brick
    position_mm: [1, 2, 3]
    joint: &slack
      stiffness_N_m: 0
      damping_N_s_m: 0
      angular_stiffness_N_m_rad: 0
      angular_damping_N_m_s_rad: 0
  two: {A: base, B: drum, position_mm: [1, 2, 3], joint: *slack}
  three: {A: base, B: orb, position_mm: [1, 2, 3], joint: *slack}
  four: {A: base, B: egg, position_mm: [1, 2, 3], joint: *slack}
  five: {A: base, B: pill, position_mm: [1, 2, 3], joint: *slack}
  six: {A: base, B: slab, position_mm: [1, 2, 3], joint: {type: revolute, rigid: true}}
orbit: {perigee_altitude_km: 211, apogee_altitude_km: 1013, true_anomaly_deg: 90}
run: {duration_s: 0.1}
"""
"""Bodies whose mass properties are computed; mesh of 200 x 300 x 500 units."""

STATE = SOLIDS.replace(
    "{perigee_altitude_km: 211, apogee_altitude_km: 1013, true_anomaly_deg: 90}",
    """
  position_km: [0, -7000, 0]
  velocity_km_s: [7.5, -1.25, 0]
  frame: ICRF
  epoch: '2027-02-03T04:05:07.125'""",
)
"""The orbit by a state."""
TAKEN = SOLIDS.replace(
    "orbit: {perigee_altitude_km: 211, apogee_altitude_km: 1013, true_anomaly_deg: 90}",
    """before_separation:
  from: handover.csv
  at: '2027-02-03T04:05:08.5'
  of: brick
  run: theirs
  body: stage""",
)
"""Orbit and attitude from a table."""
HANDOVER = (
    "label,body,epoch,time_system,frame,position_x_m,position_y_m,position_z_m,"
    "velocity_x_m_s,velocity_y_m_s,velocity_z_m_s,orientation_w,orientation_x,"
    "orientation_y,orientation_z,rate_x_rad_s,rate_y_rad_s,rate_z_rad_s\n"
    "theirs,stage,2027-02-03T04:05:08.5,TT,ICRF,7.1e6,0,0,0,7.3e3,0,1,0,0,0,"
    "0.01,0.02,0.03\n"
)
"""That table."""

# Two links, joined by a fixed joint: "arm" stands at (0.5, 0, 0) of "hull", turned by
# 90 deg about z. Both have their CG at their own origins.
URDF = """<robot name="two">
<link name="hull"><inertial><mass value="30"/>
<inertia ixx="3" iyy="4" izz="5" ixy="0" ixz="0" iyz="0"/></inertial></link>
<link name="arm"><inertial><mass value="10"/>
<inertia ixx="1" iyy="1.5" izz="2" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="weld" type="fixed"><parent link="hull"/><child link="arm"/>
<origin xyz="0.5 0 0" rpy="0 0 1.5707963267948966"/></joint></robot>"""


def write_models(folder):
    """The mesh, the model and the table that the cases name."""
    trimesh.creation.box((200, 300, 500)).export(folder / "block.stl")
    (folder / "two.urdf").write_text(URDF)
    (folder / "handover.csv").write_text(HANDOVER)
