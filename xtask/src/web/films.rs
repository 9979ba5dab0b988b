//! Films of plans by the true `ffmpeg`: the same bytes twice, and as many pictures as were drawn.

use crate::step::{self, Readiness, Surroundings};

/// Checks for `ffmpeg`, and installs it if this needs no confirmation.
pub fn readiness(here: &Surroundings) -> Readiness {
    let is_there =
        || here.command("ffmpeg", &["-version"]).output().is_ok_and(|output| output.status.success());
    if is_there() {
        return Readiness::Ready;
    }
    match here.install(&["ffmpeg"]) {
        Ok(()) if is_there() => Readiness::Ready,
        Ok(()) => Readiness::Missing("no `ffmpeg`, though apt-get has installed it".to_owned()),
        Err(reason) => Readiness::Missing(format!("no `ffmpeg`: install it ({reason})")),
    }
}

/// Plans, makes the film twice, and decodes it.
///
/// # Errors
/// If a command fails, the films differ, or one has another number of pictures.
pub fn check(here: &Surroundings) -> Result<(), String> {
    let folder = here.root.join("target/films");
    std::fs::create_dir_all(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let program = here.built_program()?.display().to_string();
    let run = |words: &str| {
        let mut command = here.command(&program, &words.split(' ').collect::<Vec<_>>());
        command.current_dir(&folder);
        command
    };
    step::succeed(run("plan 021 -o 021.plan.json --quiet"))?;
    // Those of an earlier run could be more.
    let frames = folder.join("frames");
    if frames.exists() {
        std::fs::remove_dir_all(&frames).map_err(|error| format!("{}: {error}", frames.display()))?;
    }
    for output in ["a.mp4", "b.mp4", "frames/"] {
        step::succeed(run(&format!("render 021 021.plan.json --size 160x120 --speed 0.5 -o {output}")))?;
    }
    let read = |name: &str| std::fs::read(folder.join(name)).map_err(|error| format!("{name}: {error}"));
    if read("a.mp4")? != read("b.mp4")? {
        return Err("two films of the same plan differ".to_owned());
    }
    let mut decode =
        here.command("ffmpeg", &["-hide_banner", "-nostdin", "-loglevel", "error", "-i", "a.mp4"]);
    decode.args(["-pix_fmt", "gray", "-f", "rawvideo", "a.raw", "-y"]).current_dir(&folder);
    step::succeed(decode)?;
    let drawn = std::fs::read_dir(&frames).map_err(|error| format!("{}: {error}", frames.display()))?.count();
    let shown = read("a.raw")?.len() / (160 * 120);
    if shown == drawn { Ok(()) } else { Err(format!("the film has {shown} pictures instead of {drawn}")) }
}
