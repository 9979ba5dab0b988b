use std::fmt;

use serde::de::{DeserializeOwned, IgnoredAny, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};

use crate::moveit::file::{RequestFile, SceneFile, WorldEntry};
use crate::moveit::message_file::MessageFile;
use crate::moveit::scene_text;
use crate::{MoveItError, ScenarioError};

/// Reads the planning scene of a file, in any of the forms in use:
///
/// - a `PlanningScene`, bare, as the only entry of a list, or under the `scene` of a service or an action;
/// - a `PlanningSceneWorld`; a `CollisionObject`, or a list of them;
/// - the text of a `.scene` file.
///
/// # Errors
/// [`MoveItError::NoWorld`] for a scene without a world; [`ScenarioError::Yaml`] for a key that the message does not have.
pub(crate) fn read_scene(file: &MessageFile) -> Result<SceneFile, ScenarioError> {
    /// `GetPlanningScene`, `ApplyPlanningScene`.
    #[derive(Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Service {
        #[serde(alias = "planning_scene")]
        scene: SceneFile,
    }
    if scene_text::is_scene_text(&file.text) {
        let text_bodies = scene_text::parse(&file.path, &file.text)?;
        return Ok(SceneFile::of(WorldEntry { text_bodies, ..WorldEntry::default() }));
    }
    let form: Form = file.parse()?;
    let scene = if form.has("scene") || form.has("planning_scene") {
        file.parse::<Service>()?.scene
    } else if form.has("collision_objects") || form.has("octomap") {
        SceneFile::of(file.parse()?)
    } else if form.has("id") {
        let collision_objects = form.list(file)?;
        SceneFile::of(WorldEntry { collision_objects, ..WorldEntry::default() })
    } else {
        form.only::<SceneFile>(file)?
    };
    if scene.world.is_none() {
        return Err(MoveItError::NoWorld { path: file.path.clone() }.into());
    }
    Ok(scene)
}

/// Reads the motion plan request of a file: a `MotionPlanRequest`, bare, as the only entry of a list, or under the key of a
/// service or an action.
///
/// # Errors
/// [`ScenarioError::Yaml`] for a key that the message does not have.
pub(crate) fn read_request(file: &MessageFile) -> Result<RequestFile, ScenarioError> {
    /// `GetMotionPlan`, `MoveGroup`.
    #[derive(Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Service {
        #[serde(alias = "request")]
        motion_plan_request: RequestFile,
    }
    let form: Form = file.parse()?;
    if form.has("motion_plan_request") || form.has("request") {
        return Ok(file.parse::<Service>()?.motion_plan_request);
    }
    form.only(file)
}

/// Top-level keys of a message file.
struct Form {
    /// Keys of the message, or of the first one in a list.
    keys: Vec<String>,
    /// Number of messages if the file is a list.
    messages: Option<usize>,
}

impl Form {
    fn has(&self, key: &str) -> bool {
        self.keys.iter().any(|known| known == key)
    }

    /// Returns the only message of the file.
    fn only<T: DeserializeOwned>(&self, file: &MessageFile) -> Result<T, ScenarioError> {
        let messages = self.list(file)?;
        let actual = messages.len();
        let mut messages = messages.into_iter();
        match (messages.next(), actual) {
            (Some(message), 1) => Ok(message),
            _ => Err(MoveItError::NotOneMessage { path: file.path.clone(), actual }.into()),
        }
    }

    /// Returns all messages of the file.
    fn list<T: DeserializeOwned>(&self, file: &MessageFile) -> Result<Vec<T>, ScenarioError> {
        match self.messages {
            None => Ok(vec![file.parse()?]),
            Some(_) => file.parse(),
        }
    }
}

impl<'de> Deserialize<'de> for Form {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(FormVisitor)
    }
}

struct FormVisitor;

impl<'de> Visitor<'de> for FormVisitor {
    type Value = Form;

    fn expecting(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        formatter.write_str("a message: a mapping (key: value), or a list of one")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut entries: A) -> Result<Form, A::Error> {
        let mut keys = Vec::new();
        while let Some((key, IgnoredAny)) = entries.next_entry::<String, IgnoredAny>()? {
            keys.push(key);
        }
        Ok(Form { keys, messages: None })
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut messages: A) -> Result<Form, A::Error> {
        let keys = messages.next_element::<Form>()?.map(|first| first.keys);
        let mut count = usize::from(keys.is_some());
        while messages.next_element::<IgnoredAny>()?.is_some() {
            count += 1;
        }
        Ok(Form { keys: keys.unwrap_or_default(), messages: Some(count) })
    }
}
