use cranny_scenario::{Family, built_in};

/// Classification of a scenario by its id alone.
#[derive(Clone, Debug, PartialEq)]
pub struct ScenarioClass {
    /// Environment, family or set of the scenario.
    pub environment: String,
    /// Value of its difficulty dial in metres (width of the gap, depth of the object), if it has one.
    pub dial_m: Option<f64>,
    /// Name of the dial, if known.
    pub dial: Option<&'static str>,
}

const OTHERS: &str = "other scenarios";

impl ScenarioClass {
    /// Classifies the id of a built-in scenario (`034`), of one of a sweep (`gap-0.3200`), of a generated one
    /// (`gap-00017`), or of any whose ids differ in their last digits (`bookshelf0012`).
    pub fn of(scenario: &str) -> Self {
        if let Some(entry) = built_in().find(|entry| entry.id == scenario) {
            let environment = format!("{}x: {}", &entry.id[..2], entry.environment);
            return Self {
                environment,
                dial_m: Some(entry.parameter_m),
                dial: Some(entry.family.parameter()),
            };
        }
        if let Some((name, dial)) = scenario.rsplit_once('-')
            && dial.contains('.')
            && let Ok(dial_m) = dial.parse::<f64>()
            && dial_m.is_finite()
        {
            let dial = Family::of_name(name).ok().map(Family::parameter);
            return Self { environment: format!("{name} sweep"), dial_m: Some(dial_m), dial };
        }
        let name = scenario.trim_end_matches(|c: char| c.is_ascii_digit()).trim_end_matches(['-', '_']);
        let known = !name.is_empty() && name.len() < scenario.len();
        Self { environment: if known { name } else { OTHERS }.to_owned(), dial_m: None, dial: None }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_kind_of_id_finds_its_environment() {
        for (id, environment, dial_m, dial) in [
            ("034", "03x: box behind a gap", Some(0.40), Some("gap")),
            ("gap-0.3200", "gap sweep", Some(0.32), Some("gap")),
            ("corridor-1.5", "corridor sweep", Some(1.5), None),
            ("gap-00017", "gap", None, None),
            ("bookshelf_tall0012", "bookshelf_tall", None, None),
            ("my shelf", "other scenarios", None, None),
            ("0999", "other scenarios", None, None),
            ("", "other scenarios", None, None),
        ] {
            assert_eq!(
                ScenarioClass::of(id),
                ScenarioClass { environment: environment.to_owned(), dial_m, dial },
                "{id}"
            );
        }
    }
}
