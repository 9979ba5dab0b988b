//! Check that a crate depends only on crates of a strictly lower layer (floor).

use std::collections::BTreeMap;

use crate::member::{Member, ROOMS};
use crate::problem::Problem;

/// Reports crates without a layer, and dependencies that do not lead to a lower one.
///
/// All sections of a manifest count, because a test dependency couples the crates as well.
pub fn check(members: &[Member]) -> Vec<Problem> {
    let by_name: BTreeMap<&str, &Member> =
        members.iter().map(|member| (member.name.as_str(), member)).collect();
    members.iter().filter(|member| member.is_room()).flat_map(|room| check_room(room, &by_name)).collect()
}

fn check_room(room: &Member, by_name: &BTreeMap<&str, &Member>) -> Vec<Problem> {
    let Some(floor) = room.floor else {
        return vec![Problem::new(
            room.manifest(),
            format!("{} stands on no floor", room.name),
            "add `[package.metadata.layer]` with `floor = <whole number>`",
        )];
    };
    room.dependencies
        .iter()
        .filter_map(|dependency| {
            let below = by_name.get(dependency.name.as_str())?;
            let message = match below.floor.filter(|_| below.is_room()) {
                Some(lower) if lower < floor => return None,
                Some(lower) => format!(
                    "[{}] {} (floor {floor}) uses {} (floor {lower})",
                    dependency.section, room.name, below.name
                ),
                None => {
                    format!("[{}] {} uses {}, which has no floor", dependency.section, room.name, below.name)
                }
            };
            Some(Problem::new(
                room.manifest(),
                message,
                format!(
                    "a crate in {ROOMS} uses only crates on a strictly lower floor: \
                     move the code down, or let a room above join the two"
                ),
            ))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::member::Dependency;

    fn room(name: &str, floor: Option<u64>, uses: &[(&str, &'static str)]) -> Member {
        Member {
            name: name.to_owned(),
            folder: format!("crates/{name}"),
            floor,
            dependencies: uses
                .iter()
                .map(|(name, section)| Dependency { name: (*name).to_owned(), section })
                .collect(),
            ..Member::default()
        }
    }

    #[test]
    fn downwards_is_fine_and_outside_crates_do_not_count() {
        let members = [
            room("shape", Some(1), &[("spatial", "dependencies"), ("parry3d-f64", "dependencies")]),
            room("spatial", Some(0), &[]),
        ];
        assert_eq!(check(&members), []);
    }

    #[test]
    fn upwards_and_sideways_fail_in_every_section() {
        for section in ["dependencies", "dev-dependencies", "build-dependencies"] {
            for floor in [1, 2] {
                let members =
                    [room("grasp", Some(1), &[("robot", section)]), room("robot", Some(floor), &[])];
                let problems = check(&members);
                assert_eq!(problems.len(), 1);
                assert_eq!(problems[0].place, "crates/grasp/Cargo.toml");
                assert!(problems[0].message.contains(section), "{}", problems[0]);
            }
        }
    }

    #[test]
    fn a_room_without_a_floor_fails() {
        let problems = check(&[room("attic", None, &[])]);
        assert_eq!(problems.len(), 1);
        assert!(problems[0].message.contains("no floor"));
    }

    #[test]
    fn a_room_that_uses_the_tasks_fails() {
        let tasks = Member { name: "xtask".to_owned(), folder: "xtask".to_owned(), ..Member::default() };
        let problems = check(&[room("plan", Some(4), &[("xtask", "dev-dependencies")]), tasks]);
        assert_eq!(problems.len(), 1);
    }
}
