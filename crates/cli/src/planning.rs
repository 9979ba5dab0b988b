//! `cranny plan`, `verify`, `certify`, `ik`, `roadmap` and `serve`.

pub(crate) mod certify;
pub(crate) mod explore;
pub(crate) mod explore_arguments;
pub(crate) mod ik;
pub(crate) mod obstruction;
pub(crate) mod plan;
pub(crate) mod plan_page;
pub(crate) mod plan_request;
pub(crate) mod plan_task;
pub(crate) mod roadmap;
pub(crate) mod serve;
pub(crate) mod task;
pub(crate) mod verify;
