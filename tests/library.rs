//! The library's tests: what needs no room above it compiles without studies, texts, drawings, pages and the command.

#[path = "../fmu/tests/counting/mod.rs"]
mod counting;
mod support;

/// The folder of the whole project.
const ROOT: &str = env!("CARGO_MANIFEST_DIR");

mod backlash;
mod body_shapes;
mod book;
mod component_laws;
mod component_models;
mod component_motions;
mod components;
mod contradictions;
mod dependencies;
mod driven_blocks;
mod driven_platforms;
mod effort;
mod ensemble;
mod equal_sides;
mod false_singular_poses;
mod fault_pages;
mod faults;
mod formulation_faults;
mod freewheel;
mod gallery;
mod hard_set;
mod hertz;
mod house;
mod implicit;
mod initial_values;
mod laws;
mod laws_without_value;
mod lifting_cams;
mod methods_by_name;
mod model_exchange;
mod nearly_neutral;
mod no_allocation;
mod one_sided;
mod one_sided_families;
mod only_what_is_needed;
mod other_starts;
mod paper_counts;
mod paper_quick_return;
mod paper_slider_crank;
mod paper_vibration;
mod parts;
mod placed;
mod reference;
mod reports;
mod rolling_on_circles;
mod scale;
mod scene;
mod scene_reference;
mod second_order;
mod series;
mod short_forces;
mod signals;
mod simulate_hand_made;
mod single_faults;
mod stored_programs;
mod tables;
mod taylor;
mod units;
mod values_out_of_range;
mod written_slips;
