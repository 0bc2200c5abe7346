//! What URDF has at each level, with the extensions of Gazebo, ros2_control, Isaac Sim, Bullet and Drake.

use crate::import::drake;
use crate::import::levels::Level;

pub const LEVELS: &[Level] = &[
    Level::new(
        "robot",
        "link joint transmission ros2_control loop_joint loop frame gazebo drake:ball_constraint drake:linear_bushing_rpy \
         drake:linear_spring_damper",
    )
    // What is in <mujoco> says how MuJoCo compiles the file.
    .idle("material sensor mujoco drake:collision_filter_group")
    .attributes("name version"),
    Level::new("link", "inertial collision contact").idle("visual sensor").off("self_collision_checking").attributes("name type"),
    Level::new("inertial", "origin mass inertia"),
    Level::new("origin", "").attributes("xyz rpy quat_xyzw"),
    Level::new("mass", "").attributes("value"),
    Level::new("inertia", "").attributes("ixx ixy ixz iyy iyz izz"),
    Level::new("collision", "origin geometry drake:proximity_properties").idle("verbose material").attributes("name group"),
    Level::new("geometry", "plane sphere box cylinder capsule mesh drake:capsule drake:ellipsoid sdf cone").attributes("name"),
    Level::new("plane", "").attributes("normal"),
    Level::new("sphere", "").attributes("radius"),
    Level::new("box", "").attributes("size"),
    Level::new("cylinder capsule cone drake:capsule", "").attributes("radius length"),
    Level::new("mesh sdf", "drake:declare_convex").attributes("filename scale"),
    Level::new("drake:ellipsoid", "").attributes("a b c"),
    Level::new("drake:proximity_properties", drake::OF_SURFACES).idle(drake::SOFT_SURFACES),
    Level::new("drake:mu_dynamic drake:mu_static drake:rotor_inertia drake:gear_ratio", "").attributes("value"),
    // Of Bullet: how soft a contact is, and friction about its normal, have no part in an exact planar contact.
    Level::new("contact", "lateral_friction").idle("stiffness damping contact_cfm contact_erp spinning_friction friction_anchor inertia_scaling")
        .off("rolling_friction restitution"),
    Level::new("lateral_friction", "").attributes("value"),
    Level::new("joint", "origin parent child axis limit dynamics mimic")
        .idle("calibration safety_controller hardwareInterface")
        .attributes("name type independent"),
    Level::new("parent child", "").attributes("link"),
    Level::new("axis", "").attributes("xyz"),
    Level::new("limit", "").attributes("lower upper effort velocity drake:acceleration acceleration deceleration jerk"),
    Level::new("dynamics", "").attributes("damping friction"),
    Level::new("mimic", "").attributes("joint multiplier offset"),
    Level::new("loop", "predecessor successor axis origin").attributes("name type"),
    Level::new("predecessor successor", "origin").attributes("link"),
    Level::new("loop_joint", "link1 link2 axis dynamics").idle("limit").attributes("name type"),
    Level::new("link1 link2", "").attributes("link xyz rpy"),
    Level::new("frame", "").attributes("name link xyz rpy"),
    // The reader of transmissions says which of them it takes for inputs.
    Level::new("transmission", "joint actuator type mechanicalReduction").idle("leftActuator rightActuator flexJoint rollJoint gap_joint passive_joint use_simulated_gripper_joint")
        .attributes("name type"),
    Level::new("actuator", "mechanicalReduction hardwareInterface drake:rotor_inertia drake:gear_ratio").idle("motorTorqueConstant role"),
    // An interface of effort becomes an input; of others the report says that their controller is not in the file.
    Level::new("ros2_control", "").idle("hardware joint sensor gpio transmission").attributes("name type rw_rate is_async"),
    Level::new("gazebo", "joint turnGravityOff gravity springStiffness springReference mu1")
        .idle(
            "material visual sensor mu2 kp kd minDepth maxVel maxContacts laserRetro fdir1 implicitSpringDamper provideFeedback \
             preserveFixedJoint disableFixedJointLumping stopCfm stopErp cfmDamping fudgeFactor",
        )
        .off("static dampingFactor selfCollide self_collide kinematic enable_wind")
        .attributes("reference"),
    Level::new("drake:ball_constraint", drake::OF_BALLS),
    Level::new("drake:linear_bushing_rpy", drake::OF_BUSHINGS),
    Level::new("drake:linear_spring_damper", drake::OF_SPRINGS),
];
