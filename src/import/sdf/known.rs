//! What SDFormat has at each level, up to version 1.12, and Drake's extensions of it.

use crate::import::levels::Level;

const POSE: &str = "relative_to degrees rotation_format frame";

pub const LEVELS: &[Level] = &[
    Level::new("sdf", "world model").idle("light").attributes("version"),
    Level::new("world", "gravity model joint frame physics")
        .idle("light scene gui audio magnetic_field atmosphere spherical_coordinates road")
        .off("wind"),
    // Those of a world may give its gravity; the rest is how Gazebo computes.
    Level::new("physics", "gravity")
        .idle(
            "ode bullet simbody dart dynamics_solver max_step_size real_time_factor real_time_update_rate max_contacts \
             provide_feedback",
        )
        .attributes("name default type"),
    Level::new("model", "link frame joint model pose static self_collide drake:linear_bushing_rpy drake:ball_constraint drake:linear_spring_damper")
        .idle("allow_auto_disable drake:collision_filter_group")
        .off("enable_wind")
        .attributes("name canonical_link placement_frame"),
    Level::new("pose", "").attributes(POSE),
    Level::new("frame", "pose").attributes("name attached_to"),
    Level::new("link", "pose inertial gravity collision self_collide velocity_decay")
        .idle("visual sensor light audio_sink audio_source battery projector particle_emitter must_be_base_link")
        .off("enable_wind kinematic"),
    // Its damping is left out by name.
    Level::new("velocity_decay", "linear angular"),
    Level::new("inertial", "mass pose inertia").off("fluid_added_mass").attributes("auto"),
    Level::new("inertia", "ixx ixy ixz iyy iyz izz"),
    Level::new("collision", "pose geometry surface drake:proximity_properties")
        .idle("laser_retro max_contacts density auto_inertia_params"),
    Level::new("geometry", "plane sphere box cylinder capsule ellipsoid mesh heightmap polyline image empty cone drake:capsule drake:ellipsoid")
        .attributes(""),
    Level::new("plane", "normal size"),
    Level::new("sphere", "radius"),
    Level::new("box", "size"),
    Level::new("cylinder capsule cone drake:capsule", "radius length"),
    Level::new("ellipsoid", "radii"),
    Level::new("drake:ellipsoid", "a b c"),
    // Neither has a contact: what they would touch is named.
    Level::new("mesh", "uri scale submesh drake:declare_convex").attributes("optimization"),
    Level::new("submesh", "name center"),
    Level::new("heightmap", "").idle("uri size pos texture blend use_terrain_paging sampling"),
    Level::new("polyline", "point height"),
    Level::new("image", "uri scale threshold height granularity"),
    Level::new("surface", "friction contact bounce").off("soft_contact"),
    Level::new("friction", "ode bullet torsional").attributes(""),
    // Torsional friction is about the normal of a contact, which a planar motion never turns about.
    Level::new("ode", "mu").idle("mu2 fdir1").off("slip1 slip2"),
    Level::new("bullet", "friction").idle("friction2 fdir1").off("rolling_friction"),
    Level::new("torsional", "").idle("coefficient use_patch_radius patch_radius surface_radius ode"),
    Level::new("contact", "collide_bitmask collide_without_contact")
        .idle("category_bitmask poissons_ratio elastic_modulus ode bullet collide_without_contact_bitmask"),
    Level::new("bounce", "").idle("threshold").off("restitution_coefficient"),
    Level::new("drake:proximity_properties", super::drake::OF_SURFACES).idle(super::drake::SOFT_SURFACES),
    Level::new("joint", "parent child pose axis axis2 gearbox_ratio gearbox_reference_body drake:mimic drake:rotor_inertia drake:gear_ratio")
        .idle("physics sensor")
        .attributes("name type"),
    Level::new("axis axis2", "xyz dynamics limit initial_position use_parent_model_frame mimic"),
    Level::new("xyz", "").attributes("expressed_in"),
    Level::new("dynamics", "damping friction spring_reference spring_stiffness"),
    // How soft a stop is, is a number for which the exact stop stands.
    Level::new("limit", "lower upper stiffness dissipation").idle("effort drake:acceleration").off("velocity"),
    Level::new("mimic", "multiplier offset reference").attributes("joint axis"),
    Level::new("drake:mimic", "").attributes("joint multiplier offset"),
    Level::new("drake:ball_constraint", super::drake::OF_BALLS),
    Level::new("drake:linear_bushing_rpy", super::drake::OF_BUSHINGS),
    Level::new("drake:linear_spring_damper", super::drake::OF_SPRINGS),
];
