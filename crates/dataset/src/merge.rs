use std::path::{Path, PathBuf};

use crate::card::write_card;
use crate::folder::{DatasetDescription, DatasetFolder};
use crate::{DatasetError, DatasetShard};

/// Merges the complete shards of a data set into a new folder, which is the same, byte for byte, as if one process had made it.
/// The files of the shards are linked where the file system allows it, and copied otherwise; `done` is called after each chunk.
///
/// # Errors
/// [`DatasetError::Shards`] for shards of other recipes or versions, for one that is given twice, missing or incomplete.
pub fn merge(shards: &[PathBuf], into: &Path, done: &mut dyn FnMut()) -> Result<DatasetFolder, DatasetError> {
    let fault = |path: &Path, problem: String| DatasetError::Shards { path: path.to_owned(), problem };
    let folders: Vec<DatasetFolder> =
        shards.iter().map(|path| DatasetFolder::open(path)).collect::<Result<_, _>>()?;
    let Some(first) = folders.first() else {
        return Err(fault(into, "no shards are given".to_owned()));
    };
    let whole = |folder: &DatasetFolder| DatasetDescription { shard: None, ..folder.description().clone() };
    let shard_of = |folder: &DatasetFolder| folder.description().shard.unwrap_or(DatasetShard::WHOLE);
    let of = shard_of(first).of;
    let mut places = vec![None; usize::try_from(of).unwrap_or(usize::MAX)];
    for folder in &folders {
        let shard = shard_of(folder);
        if whole(folder) != whole(first) || shard.of != of || !folder.has_robots_of(first)? {
            let other = first.path().display();
            return Err(fault(folder.path(), format!("is a shard of another data set than {other}")));
        }
        let place = usize::try_from(shard.index - 1).ok().and_then(|index| places.get_mut(index));
        if let Some(place) = place {
            if place.is_some() {
                return Err(fault(folder.path(), format!("holds shard {shard}, which is given twice")));
            }
            *place = Some(folder);
        }
        for chunk in folder.chunks() {
            if !folder.has(chunk)? {
                let problem = format!(
                    "shard {shard} is not complete: chunk {chunk} is missing; the same `dataset generate` resumes it"
                );
                return Err(fault(folder.path(), problem));
            }
        }
    }
    if let Some(missing) = places.iter().position(Option::is_none) {
        let shard = DatasetShard { index: missing as u64 + 1, of };
        return Err(fault(first.path(), format!("shard {shard} is missing")));
    }
    let description = DatasetDescription { recipe: first.recipe_at_home(), ..whole(first) };
    let merged = DatasetFolder::create(into, description)?;
    for folder in places.into_iter().flatten() {
        for chunk in folder.chunks() {
            for (from, to) in folder.all_files(chunk).zip(merged.all_files(chunk)) {
                cranny_scenario::write_whole_file_by(&to, |partial| {
                    let linked = std::fs::hard_link(&from, partial);
                    let copied = linked.or_else(|_| std::fs::copy(&from, partial).map(drop));
                    copied.map_err(|reason| cranny_scenario::ScenarioError::Unwritable {
                        path: to.clone(),
                        reason,
                    })
                })?;
            }
            done();
        }
    }
    write_card(&merged)?;
    Ok(merged)
}
