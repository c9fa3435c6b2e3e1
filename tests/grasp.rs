//! Hands, objects and grasps. All these files form one test program, because each program must be linked.

#[path = "../analysis/between_points.rs"]
mod between_points;
#[path = "../analysis/contact_points/search.rs"]
mod contact_points;
mod depth;
mod described;
mod failures;
mod force_closure;
mod force_closure_estimate;
mod grasp_energy;
mod grasp_layer;
mod hand_files;
mod hands;
mod mano;
mod mjcf;
mod neural;
mod objects;
mod published;
#[path = "../analysis/relaxed.rs"]
mod relaxed;
mod shapes;
mod skipped;
mod stability;
mod synthesis;
mod table;
mod taxonomy_fixtures;
mod toy_hand;
