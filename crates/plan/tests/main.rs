//! Integration tests of this crate in one program, which is linked once.

#![allow(clippy::disallowed_methods, reason = "what is compared to may come from the system")]

mod excluded_grasps;
mod fixture;

mod audit;
mod audit_limits;
mod bad_input;
mod baselines;
mod full_turns;
mod grasp_choice;
mod guess;
mod hand_filter;
mod ik_annotation;
mod optimise;
mod optimisers;
mod own_grasps;
mod planners;
mod regions;
mod roadmap;
mod shortcut;
mod trajectory;
mod twins;
